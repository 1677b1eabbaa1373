// What a pane of glass adds to what the eye sees: probe, false colours, regions, sweeps, files.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/inspection/not_modelled.h"
#include "render/views/false_color.h"
#include "ui/widgets.h"

namespace maquette {

float ev100_of(float cdm2) { return std::log2(std::max(cdm2, 1e-9f) * 100.0f / 12.5f); }

std::string plain_number(double value) {
  char text[64];
  const double size = std::abs(value);
  const bool whole = size >= 1000.0 && size < 1e15;
  std::snprintf(text, sizeof text, whole ? "%.0f" : "%.4g", value);
  return text;
}

std::array<float, 3> luminance_color(float cdm2, float low_cdm2, float high_cdm2) {
  if (!(cdm2 > 0.0f)) return {0.0f, 0.0f, 0.0f};
  if (cdm2 < low_cdm2) return {0.0f, 0.0f, 0.35f};
  if (cdm2 > high_cdm2) return {1.0f, 0.0f, 1.0f};
  Image value(1, 1, 1, std::log(cdm2 / low_cdm2));
  const Image color = false_color_image(value, FalseColorRange{0.0f, std::log(high_cdm2 / low_cdm2)});
  return {color.data[0], color.data[1], color.data[2]};
}

}  // namespace maquette

namespace maquette::panels {

void draw_rows(const std::vector<std::pair<std::string, std::string>>& rows) {
  for (const auto& [name, value] : rows) {
    ImGui::TextColored(kDim, "%s", name.c_str());
    ImGui::SameLine(scaled(112.0f));
    ImGui::TextWrapped("%s", value.c_str());
  }
}

namespace {

void draw_eye(Ui& ui) {
  InspectionView& view = ui.state.inspection;
  if (ui.facts.inspection.has_r_point) {
    dim_text("R-point: the node r_point");
  } else {
    row_label("R-point, m", "In the scene; a node named r_point would be used instead");
    number_fields(ui, "inspection/r_point", view.r_point_m.data(), 3, "%.3f");
  }
  if (ImGui::Button("Eye at V1")) ui.actions.inspection.eye_point = 1;
  mark_item(ui, "inspection/v1");
  tooltip(
      "68 mm behind, 665 mm above the R-point (78/318/EEC); the camera keeps its direction. The car drives towards +Z, "
      "+X is at its left");
  ImGui::SameLine();
  if (ImGui::Button("Eye at V2")) ui.actions.inspection.eye_point = 2;
  mark_item(ui, "inspection/v2");
  tooltip("68 mm behind, 589 mm above the R-point");
  row_label("Own, mm", "An eye of your own: rearward, right and up from the R-point");
  number_fields(ui, "inspection/own eye", view.eye_mm.data(), 3, "%.0f");
  if (ImGui::Button("Eye there")) ui.actions.inspection.eye_point = 3;
  mark_item(ui, "inspection/own");
  ImGui::SameLine();
  static const char* const kEyes[] = {"between both", "left eye", "right eye"};
  ImGui::SetNextItemWidth(-FLT_MIN);
  ImGui::Combo("##which", &view.which_eye, kEyes, 3);
  mark_item(ui, "inspection/which eye");
  tooltip("Which eye of the head the buttons take: 65 mm lie between them");
  ImGui::Checkbox("right-hand drive", &view.right_hand_drive);
  mark_item(ui, "inspection/right-hand drive");
}

void draw_legend(Ui& ui) {
  const InspectionView& view = ui.state.inspection;
  const float width = ImGui::GetContentRegionAvail().x, height = scaled(14.0f);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList* list = ImGui::GetWindowDrawList();
  constexpr int kSteps = 48;
  for (int i = 0; i < kSteps; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / kSteps;
    const auto c =
        luminance_color(view.low_cdm2 * std::pow(view.high_cdm2 / view.low_cdm2, t), view.low_cdm2, view.high_cdm2);
    list->AddRectFilled({at.x + width * static_cast<float>(i) / kSteps, at.y},
                        {at.x + width * static_cast<float>(i + 1) / kSteps, at.y + height},
                        ImGui::GetColorU32(ImVec4(c[0], c[1], c[2], 1.0f)));
  }
  ImGui::Dummy({width, height});
  mark_item(ui, "inspection/legend");
  const float middle = std::sqrt(view.low_cdm2 * view.high_cdm2);
  const auto label = [&](float cdm2) {
    char ev[32];
    std::snprintf(ev, sizeof ev, "%.1f EV", static_cast<double>(ev100_of(cdm2)));
    return view.in_ev ? std::string(ev) : plain_number(static_cast<double>(cdm2)) + (cdm2 == middle ? "" : " cd/m2");
  };
  // Each below its place on the scale.
  const float left = ImGui::GetCursorPosX();
  const std::string texts[] = {label(view.low_cdm2), label(middle), label(view.high_cdm2)};
  for (int i = 0; i < 3; ++i) {
    const float share = 0.5f * static_cast<float>(i);
    if (i > 0) ImGui::SameLine(left + share * (width - ImGui::CalcTextSize(texts[i].c_str()).x));
    ImGui::TextUnformatted(texts[i].c_str());
    mark_item(ui, "inspection/legend/" + std::to_string(i));
  }
  dim_text("dark blue: below the scale; magenta: above it");
}

void luminance_slider(const char* id, float* cdm2, float low, float high) {
  slider(id, cdm2, low, high, *cdm2 >= 100.0f ? "%.0f cd/m2" : "%.3g cd/m2",
         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
}

void draw_colors(Ui& ui) {
  InspectionView& view = ui.state.inspection;
  ImGui::Checkbox("False colours", &view.false_color);
  mark_item(ui, "inspection/false colors");
  tooltip("Luminance of the picture, before exposure and tone mapping");
  ImGui::SameLine();
  ImGui::Checkbox("in EV", &view.in_ev);
  mark_item(ui, "inspection/ev");
  tooltip("Exposure value at ISO 100, as a luminance meter shows it");
  row_label("From", "Lower end of the scale");
  luminance_slider("##low", &view.low_cdm2, 1e-2f, 1e5f);
  mark_item(ui, "inspection/low");
  row_label("To", "Upper end of the scale");
  luminance_slider("##high", &view.high_cdm2, 1e-1f, 1e9f);
  mark_item(ui, "inspection/high");
  view.high_cdm2 = std::max(view.high_cdm2, 1.01f * view.low_cdm2);
  if (view.false_color) draw_legend(ui);
  row_label("Layer", "Of the light at panes: all; what is seen through them; what they mirror; the second image alone");
  std::string layer = ui.state.settings.get_string("reflections.layer");
  if (combo("##layer", &layer, {"all", "transmitted", "reflected", "ghost"})) {
    ui.state.settings.set("reflections.layer", layer);
    if (layer == "ghost") ui.state.settings.set("reflections.ghost", true);
  }
  mark_item(ui, "inspection/layer");
  row_label("Polarisation", "What the pane does to s or p alone, or what polarised sunglasses let through");
  static const char* const kNames[] = {"all", "s", "p", "sunglasses"};
  ImGui::Combo("##polarisation", &view.polarisation, kNames, 4);
  mark_item(ui, "inspection/polarisation");
}

void draw_regions(Ui& ui) {
  InspectionView& view = ui.state.inspection;
  const bool on = ui.state.tool == Tool::region;
  if (toggle_button("Draw a region", on)) ui.state.tool = on ? Tool::camera : Tool::region;
  mark_item(ui, "inspection/region");
  tooltip("Then drag over the picture; Esc leaves");
  ImGui::SameLine();
  if (ImGui::Button("Remove all")) view.regions.clear();
  mark_item(ui, "inspection/clear");
  row_label("Threshold", "Regions tell the share of their pixels above it");
  luminance_slider("##threshold", &view.threshold_cdm2, 1.0f, 1e5f);
  mark_item(ui, "inspection/threshold");
  row_label("Contrast", "What should be seen through the pane: whatever is there, or an object of one luminance");
  static const char* const kBackgrounds[] = {"of what is seen", "of an object"};
  int given = view.background_given ? 1 : 0;
  if (ImGui::Combo("##contrast", &given, kBackgrounds, 2)) view.background_given = given == 1;
  mark_item(ui, "inspection/contrast");
  if (view.background_given) {
    row_label("Its luminance", "Of the object, before the pane dims it");
    luminance_slider("##background", &view.background_cdm2, 1e-2f, 1e6f);
    mark_item(ui, "inspection/background");
  }
  for (std::size_t i = 0; i < ui.facts.inspection.regions.size(); ++i) {
    ImGui::TextColored(kAccent, "Region %zu", i + 1);
    draw_rows(ui.facts.inspection.regions[i].values);
  }
  if (view.regions.empty()) dim_text("None yet: the export measures all pixels that show the pane.");
}

/// Under what sweeps and files are measured.
void draw_conditions(Ui& ui) {
  InspectionView& view = ui.state.inspection;
  dim_text("Of trends and files; the probe and regions show the picture as it is.");
  row_label("Light", "As it is; scaled to lux on the pane's outer face; or displays and lamps of the scene alone");
  static const char* const kLights[] = {"as it is", "lux on the glass", "night: none outside"};
  int light = static_cast<int>(view.light);
  if (ImGui::Combo("##light", &light, kLights, 3)) view.light = static_cast<InspectionView::Light>(light);
  mark_item(ui, "inspection/light");
  if (view.light == InspectionView::Light::given) {
    row_label("On the glass", "Illuminance of the pane's outer face");
    slider("##lux", &view.lux_on_glass, 1.0f, 2e5f, "%.0f lx",
           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    mark_item(ui, "inspection/lux");
  }
  row_label("Eyes across", "Across and down the eye box, measured each; the worst is named");
  slider("##columns", &view.grid[0], 1, kMostGrid);
  mark_item(ui, "inspection/columns");
  row_label("Eyes down");
  slider("##rows", &view.grid[1], 1, kMostGrid);
  mark_item(ui, "inspection/rows");
  row_label("Eye box, mm", "Width and height in which these eyes lie, around the eye of the camera");
  number_fields(ui, "inspection/eye box", view.eye_box_mm.data(), 2, "%.0f");
  for (float& side : view.eye_box_mm) side = std::clamp(side, 0.0f, kMostEyeBox_mm);
  ImGui::Checkbox("left and right eye", &view.both_eyes);
  mark_item(ui, "inspection/both eyes");
  ImGui::Checkbox("matte dashboard", &view.dash_given);
  mark_item(ui, "inspection/dash");
  tooltip("What the pane mirrors most becomes Lambertian with this reflectance");
  if (!view.dash_given) return;
  row_label("Reflectance");
  slider("##dash", &view.dash_reflectance, 0.0f, 1.0f, "%.2f");
  mark_item(ui, "inspection/dash reflectance");
}

/// The step of a sweep under the mouse, instead of its number.
void name_step(const InspectionFacts& facts) {
  if (!ImGui::IsItemHovered()) return;
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  const float share = (ImGui::GetIO().MousePos.x - low.x) / std::max(high.x - low.x, 1.0f);
  const float last = static_cast<float>(facts.sweep_y.size() - 1);
  const auto at = static_cast<std::size_t>(std::clamp(std::round(share * last), 0.0f, last));
  if (std::isnan(facts.sweep_y[at]))
    return ImGui::SetTooltip("%s %s: the eye does not look through the pane",
                             plain_number(static_cast<double>(facts.sweep_x[at])).c_str(), facts.sweep_unit.c_str());
  ImGui::SetTooltip("%s %s: %s %s", plain_number(static_cast<double>(facts.sweep_x[at])).c_str(),
                    facts.sweep_unit.c_str(), plain_number(static_cast<double>(facts.sweep_y[at])).c_str(),
                    facts.sweep_measure.c_str());
}

void draw_sweep(Ui& ui) {
  InspectionView& view = ui.state.inspection;
  const InspectionFacts& facts = ui.facts.inspection;
  const float top = ImGui::GetCursorPosY();
  dim_text(facts.sun);
  hold_lines(top, 2.0f);
  row_label("Vary", "Sun, rake and the rest, from this eye, path traced on few pixels");
  if (facts.sweep_names.empty()) return;
  const int count = static_cast<int>(facts.sweep_names.size());
  view.sweep = std::clamp(view.sweep, 0, count - 1);
  if (ImGui::BeginCombo("##sweep", facts.sweep_names[static_cast<std::size_t>(view.sweep)].c_str())) {
    for (int i = 0; i < count; ++i)
      if (ImGui::Selectable(facts.sweep_names[static_cast<std::size_t>(i)].c_str(), i == view.sweep) &&
          std::exchange(view.sweep, i) != i)
        view.sweep_range = usual_range(i);  // the numbers were of the other quantity
    ImGui::EndCombo();
  }
  mark_item(ui, "inspection/sweep");
  row_label(elide("In " + facts.sweep_unit, scaled(104.0f)).c_str(), "From and to");
  number_fields(ui, "inspection/range", view.sweep_range.data(), 2, "%.4g");
  row_label("Steps");
  slider("##steps", &view.sweep_count, 2, kMostSweepSteps);
  mark_item(ui, "inspection/steps");
  ImGui::BeginDisabled(!facts.job.empty());
  if (ImGui::Button("Run")) ui.actions.inspection.run_sweep = true;
  mark_item(ui, "inspection/run");
  ImGui::EndDisabled();
  if (facts.sweep_y.empty()) return;
  // Steps at which no eye looks through the pane have no value.
  const auto less = [](float a, float b) { return !(a >= b) && !std::isnan(b); };
  const auto largest = std::ranges::max_element(facts.sweep_y, less);
  const float most = std::isnan(*largest) ? 0.0f : *largest;
  const auto blind = std::ranges::count_if(facts.sweep_y, [](float y) { return std::isnan(y); });
  ImGui::PlotLines("##plot", facts.sweep_y.data(), static_cast<int>(facts.sweep_y.size()), 0, facts.sweep_title.c_str(),
                   0.0f, 1.1f * std::max(most, 1e-9f), {ImGui::GetContentRegionAvail().x, scaled(110.0f)});
  name_step(facts);
  mark_item(ui, "inspection/plot");
  const auto worst = largest - facts.sweep_y.begin();
  char text[160];
  std::snprintf(text, sizeof text, "%.4g to %.4g %s; largest %s %s at %.4g", static_cast<double>(facts.sweep_x.front()),
                static_cast<double>(facts.sweep_x.back()), facts.sweep_unit.c_str(),
                plain_number(static_cast<double>(most)).c_str(), facts.sweep_measure.c_str(),
                static_cast<double>(facts.sweep_x[static_cast<std::size_t>(worst)]));
  ImGui::TextWrapped("%s", text);
  if (blind > 0)
    ImGui::TextWrapped("Left out: %d of %zu steps, at which the eye does not look through the pane",
                       static_cast<int>(blind), facts.sweep_y.size());
}

void draw_export(Ui& ui) {
  InspectionView& view = ui.state.inspection;
  row_label("File", "CSV or JSON of regions and assumptions; the layers go beside it as .exr");
  ImGui::InputText("##export", view.export_path.data(), view.export_path.size());
  mark_item(ui, "inspection/path");
  ImGui::BeginDisabled(!ui.facts.inspection.job.empty());
  if (ImGui::Button("Export")) ui.actions.inspection.export_files = true;
  mark_item(ui, "inspection/export");
  ImGui::EndDisabled();
}

}  // namespace

void draw_inspection_panel(Ui& ui) {
  ui.state.inspection.open = true;
  const InspectionFacts& facts = ui.facts.inspection;
  const float top = ImGui::GetCursorPosY();
  dim_text(!facts.status.empty() ? facts.status : "Rest the mouse on the picture: what its pixel shows.");
  hold_lines(top, 2.0f);
  const auto part = [&](const char* title, void (*draw)(Ui&)) {
    const bool shown = section(ui, title);
    mark_item(ui, std::string("inspection/") + title);
    if (shown) draw(ui);
  };
  if (ui.facts.stored_light.any) part("Stored light", draw_stored_light);
  part("Eye", draw_eye);
  part("Luminance", draw_colors);
  part("Regions", draw_regions);
  part("Conditions", draw_conditions);
  part("Trends", draw_sweep);
  part("Files", draw_export);
  draw_rows(facts.worst);
  if (!facts.job.empty()) {
    ImGui::ProgressBar(facts.job_share, {-FLT_MIN, 0.0f}, "");
    dim_text(facts.job + (facts.job_seconds_left < 0.0 ? "" : ", " + time_left_text(facts.job_seconds_left)));
    if (ImGui::Button("Cancel")) ui.actions.inspection.cancel = true;
    mark_item(ui, "inspection/cancel");
  }
  std::string left_out;
  for (const char* what : kNotModelled) left_out += (left_out.empty() ? "Not modelled: " : "; ") + std::string(what);
  dim_text(left_out + ".");
}

}  // namespace maquette::panels

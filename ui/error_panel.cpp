// The error of the picture, its distribution, and settings that keep an error budget.
#include <algorithm>
#include <cstdio>

#include "scenes/percent.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

void draw_figure(const MeterFacts& meter) {
  const float top = ImGui::GetCursorPosY();
  if (meter.has_error) {
    ImGui::SetWindowFontScale(1.6f);
    ImGui::TextUnformatted(percent_text(meter.error).c_str());
    ImGui::SetWindowFontScale(1.0f);
    dim_text("relative RMSE, 95 % sure: " + percent_text(meter.low) + " to " + percent_text(meter.high));
    char text[96];
    std::snprintf(text, sizeof text, "%d pixels, %d paths each, %.1f s", meter.pixels, meter.paths, meter.seconds);
    dim_text(text);
  }
  if (!meter.status.empty()) dim_text(meter.status);
  if (!meter.reference_answer.empty()) dim_text(meter.reference_answer);
  hold_lines(top, 6.5f);  // the large figure and five lines
}

void draw_meter(Ui& ui) {
  // Controls first: they stay where they are when figures come and go.
  ErrorView& view = ui.state.error_view;
  row_label("Against",
            "All light: the error against all light paths. Direct light: the error of what the mode claims to compute");
  static const char* const kReferences[] = {"all light", "direct light"};
  int reference = view.all_light ? 0 : 1;
  if (ImGui::Combo("##against", &reference, kReferences, 2)) view.all_light = reference == 0;
  mark_item(ui, "error/against");
  const auto choice = [&](const char* label, ErrorView::Show show, const char* name) {
    if (ImGui::RadioButton(label, view.show == show)) view.show = show;
    mark_item(ui, name);
    tooltip("Heat: where the error is. Wiper: the mode at the left, the reference at the right; drag its line");
  };
  choice("picture", ErrorView::Show::picture, "error/picture");
  ImGui::SameLine();
  choice("heat map", ErrorView::Show::heat, "error/heat");
  ImGui::SameLine();
  choice("wiper", ErrorView::Show::wiper, "error/wiper");
  if (view.show == ErrorView::Show::heat) dim_text("blue none, green the mean error, red four times it");
  if (view.show == ErrorView::Show::wiper) {
    row_label("Wiper");
    ImGui::SliderFloat("##wiper", &view.wiper, 0.0f, 1.0f, "");
    mark_item(ui, "error/wiper position");
  }
  draw_figure(ui.facts.meter);
}

void draw_budget(Ui& ui) {
  ErrorView& view = ui.state.error_view;
  const MeterFacts& meter = ui.facts.meter;
  float budget = 100.0f * view.budget;
  row_label("Budget", "The largest relative RMSE that the mode's settings may have");
  if (slider("##budget", &budget, 0.5f, 200.0f, "%.1f %%", ImGuiSliderFlags_Logarithmic)) view.budget = 0.01f * budget;
  if (ImGui::IsItemDeactivatedAfterEdit() && meter.can_apply) ui.actions.apply_budget = true;
  mark_item(ui, "error/budget");
  const float top = ImGui::GetCursorPosY();
  dim_text(meter.budget_answer);
  hold_lines(top, 4.0f);
  ImGui::BeginDisabled(!meter.can_apply);
  if (ImGui::Button("Use these settings")) ui.actions.apply_budget = true;
  mark_item(ui, "error/apply");
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Button(meter.measuring_curve ? "Measuring ..." : "Measure this view") && !meter.measuring_curve)
    ui.actions.measure_curve = true;
  mark_item(ui, "error/measure");
  dim_text(meter.curve.empty() ? " " : "Curve: " + meter.curve);
}

/// Errors of the whole picture, which differ by its mirrors and panes alone.
void draw_reflectors(Ui& ui) {
  const MeterFacts& meter = ui.facts.meter;
  if (ImGui::Button(meter.comparing_reflectors ? "Comparing ..." : "Compare techniques") && !meter.comparing_reflectors)
    ui.actions.compare_reflectors = true;
  mark_item(ui, "error/reflectors");
  tooltip("Draws this view with every reflector technique and measures the picture's error");
  for (const MeterFacts::Reflector& reflector : meter.reflectors) {
    char text[64];
    std::snprintf(text, sizeof text, "%s, %.0f ms", percent_text(reflector.error).c_str(), reflector.time_ms);
    value_row(reflector.name.c_str(), reflector.why.empty() ? text : "cannot draw this view");
    tooltip(reflector.why);
  }
}

}  // namespace

void draw_error_panel(Ui& ui) {
  ui.state.error_view.open = true;
  if (section(ui, "Error of the picture")) draw_meter(ui);
  if (section(ui, "Error budget")) draw_budget(ui);
  if (ui.state.reflections != kNoReflections && section(ui, "Reflector techniques")) draw_reflectors(ui);
}

}  // namespace maquette::panels

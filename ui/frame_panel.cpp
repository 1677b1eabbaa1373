// The cost of the frame, its plan with reasons, and the messages so far.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ui/widgets.h"

namespace maquette::panels {

namespace {

std::string thousands(std::size_t value) {
  std::string text = std::to_string(value);
  for (int i = static_cast<int>(text.size()) - 3; i > 0; i -= 3) text.insert(static_cast<std::size_t>(i), " ");
  return text;
}

/// True when it is clicked.
bool bar_row(const std::string& label, double value, double whole, const char* text, bool chosen) {
  const float width = ImGui::GetContentRegionAvail().x;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float height = ImGui::GetTextLineHeight() + scaled(4.0f);
  const bool clicked = ImGui::Selectable(("##" + label).c_str(), chosen, 0,
                                         {width, height - ImGui::GetStyle().ItemSpacing.y + scaled(3.0f)});
  const float fraction = whole > 0.0 ? static_cast<float>(std::clamp(value / whole, 0.0, 1.0)) : 0.0f;
  ImDrawList* list = ImGui::GetWindowDrawList();
  if (!chosen && !ImGui::IsItemHovered())
    list->AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), scaled(3.0f));
  if (fraction > 0.004f)
    list->AddRectFilled(at, {at.x + width * fraction, at.y + height},
                        ImGui::ColorConvertFloat4ToU32({kAccent.x, kAccent.y, kAccent.z, 0.45f}), scaled(3.0f));
  const float text_y = at.y + scaled(2.0f);
  list->AddText({at.x + scaled(6.0f), text_y}, ImGui::GetColorU32(ImGuiCol_Text), label.c_str());
  list->AddText({at.x + width - ImGui::CalcTextSize(text).x - scaled(6.0f), text_y}, ImGui::GetColorU32(ImGuiCol_Text),
                text);
  return clicked;
}

/// Times of the last frames, one a line, passes in columns.
std::string history_csv(const EditorFacts& facts) {
  std::string text = "frame_ms";
  for (const auto& [name, times] : facts.pass_history_ms) text += "," + name;
  for (std::size_t i = 0; i < facts.frame_history_ms.size(); ++i) {
    char number[32];
    std::snprintf(number, sizeof number, "\n%.3f", static_cast<double>(facts.frame_history_ms[i]));
    text += number;
    for (const auto& [name, times] : facts.pass_history_ms) {
      std::snprintf(number, sizeof number, ",%.3f", static_cast<double>(i < times.size() ? times[i] : 0.0f));
      text += number;
    }
  }
  return text + "\n";
}

/// Of the whole frame, or of the pass that is chosen.
void draw_history(Ui& ui) {
  const FrameStats& stats = *ui.facts.stats;
  const auto pass = ui.facts.pass_history_ms.find(ui.state.frame_pass);
  const bool whole = pass == ui.facts.pass_history_ms.end();
  const std::vector<float>& history = whole ? ui.facts.frame_history_ms : pass->second;
  if (history.empty()) return;
  char text[160];
  if (whole)
    std::snprintf(text, sizeof text, "%.1f ms, %.1f frames/s", stats.frame_ms, 1000.0 / std::max(stats.frame_ms, 1e-3));
  else
    std::snprintf(text, sizeof text, "%.2f ms", static_cast<double>(history.back()));
  value_row(whole ? "frame" : pass->first.c_str(), text);
  const float peak = *std::max_element(history.begin(), history.end());
  std::snprintf(text, sizeof text, "0 to %s ms, last %zu frames", plain_number(static_cast<double>(peak)).c_str(),
                history.size());
  ImGui::PlotLines("##history", history.data(), static_cast<int>(history.size()), 0, text, 0.0f, 1.4f * peak,
                   {ImGui::GetContentRegionAvail().x, scaled(64.0f)});
  mark_item(ui, "frame/history");
}

void draw_timings(Ui& ui) {
  const FrameStats& stats = *ui.facts.stats;
  char text[64];
  draw_history(ui);
  // Above the passes, whose number changes from frame to frame.
  if (ImGui::Button("Copy the times")) ImGui::SetClipboardText(history_csv(ui.facts).c_str());
  mark_item(ui, "frame/copy");
  tooltip("Of the last frames and of each of their passes, as CSV");
  double total = 0.0;
  for (const PassTime& pass : ui.facts.smooth_passes) total += pass.ms;
  for (const PassTime& pass : ui.facts.smooth_passes) {
    std::snprintf(text, sizeof(text), "%.2f ms", pass.ms);
    const std::string title = stats.plan.pass_title(pass.name, pass.layer);
    const bool chosen = title == ui.state.frame_pass;
    if (bar_row(title, pass.ms, total, text, chosen)) ui.state.frame_pass = chosen ? "" : title;
    mark_item(ui, "pass/" + title);
    tooltip("Click: its times in the last frames");
  }
  ImGui::Spacing();
  value_row("Visible points", thousands(stats.visible_pixels));
  std::string shaded = thousands(stats.shaded_pixels);
  if (stats.visible_pixels > 0) {
    std::snprintf(text, sizeof(text), "  (%.1f %%)",
                  100.0 * static_cast<double>(stats.shaded_pixels) / static_cast<double>(stats.visible_pixels));
    shaded += text;
  }
  value_row("Shaded points", shaded);
  value_row("Shading samples", thousands(stats.shading_samples));
  value_row("Frames averaged", std::to_string(stats.accumulated_frames));
  for (const auto& [name, value] : stats.technique) {
    std::snprintf(text, sizeof(text), "%g", value);
    value_row(name.c_str(), text);
  }
}

void plan_entry(const std::string& name, const std::string& why, bool done) {
  ImGui::TextColored(done ? kAccent : kDim, "%s", glyph("\u25b8", ">"));
  ImGui::SameLine(0.0f, scaled(5.0f));
  ImGui::TextUnformatted(name.c_str());
  ImGui::Indent();
  dim_text(why);
  ImGui::Unindent();
}

/// What the frame continues.
void draw_status(const FrameStatus& status) {
  value_row("Frames before", std::to_string(status.accumulated));
  if (status.light_rotated) value_row("Changed", "rotation of the environment");
  if (status.tables_swapped) value_row("Changed", "measured tables");
}

/// The passes in their order, those that this frame did not need dimmed and with the reason; then what else it has.
void draw_plan(const FramePlan& plan, const std::vector<SkippedPass>& skipped) {
  for (const PlannedPass& pass : plan.passes) {
    const auto skip = std::find_if(skipped.begin(), skipped.end(),
                                   [&](const SkippedPass& s) { return s.name == pass.name && s.layer == pass.layer; });
    plan_entry(plan.pass_title(pass.name, pass.layer), skip == skipped.end() ? pass.reason : "skipped: " + skip->why,
               skip == skipped.end());
  }
  for (const Feature& feature : plan.features) plan_entry(feature.name, feature.reason, true);
  if (plan.left_out.empty()) return;
  ImGui::Spacing();
  ImGui::TextUnformatted("Left out");
  ImGui::Separator();
  for (const LeftOut& left : plan.left_out) {
    ImGui::TextUnformatted(left.what.c_str());
    ImGui::Indent();
    dim_text(left.why);
    ImGui::Unindent();
  }
}

void draw_messages(Ui& ui) {
  if (!ui.facts.messages || ui.facts.messages->empty()) {
    dim_text("Nothing so far.");
    return;
  }
  for (auto it = ui.facts.messages->rbegin(); it != ui.facts.messages->rend(); ++it) {
    const ImVec4 color = it->level == MessageLevel::error     ? kError
                         : it->level == MessageLevel::warning ? kWarning
                                                              : kDim;
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::TextWrapped("%s", it->text.c_str());
    ImGui::PopStyleColor();
  }
}

}  // namespace

void draw_frame_panel(Ui& ui) {
  if (ui.facts.stats) {
    if (section(ui, "Timings")) draw_timings(ui);
    if (section(ui, "Plan")) {
      draw_status(ui.facts.stats->status);
      draw_plan(ui.facts.stats->plan, ui.facts.stats->skipped);
    }
    draw_bakes(ui);
    if (section(ui, "Memory", false)) {
      std::size_t total = 0;
      for (const auto& [name, bytes] : ui.facts.stats->gpu_bytes) {
        value_row(name.c_str(), byte_text(bytes));
        total += bytes;
      }
      value_row("Sum", byte_text(total));
    }
  }
  if (section(ui, "Messages")) draw_messages(ui);
}

}  // namespace maquette::panels

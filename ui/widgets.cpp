#include "ui/widgets.h"

#define IMGUI_DEFINE_MATH_OPERATORS
#include <imgui_internal.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "scenes/error.h"

namespace maquette::panels {

const ImVec4 kDim{0.55f, 0.55f, 0.57f, 1.0f};
const ImVec4 kAccent{0.30f, 0.58f, 0.80f, 1.0f};
const ImVec4 kWarning{0.90f, 0.71f, 0.36f, 1.0f};
const ImVec4 kError{0.93f, 0.45f, 0.42f, 1.0f};

namespace {
constexpr float kThemeFontSize = 15.0f;
constexpr float kLabelWidth = 104.0f;
constexpr float kMostTyped = 1e9f;  // `1e39` would be infinite, and no review could be read again

std::string pretty(std::string name) {
  if (const std::size_t dot = name.find('.'); dot != std::string::npos) name.erase(0, dot + 1);
  std::replace(name.begin(), name.end(), '_', ' ');
  if (!name.empty()) name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return name;
}

std::string full_help(const SettingDeclaration& declaration) {
  std::string text = declaration.name + "\n" + declaration.help + "\nDefault " + to_text(declaration.default_value);
  if (!declaration.unit.empty()) text += " " + declaration.unit;
  if (declaration.min != declaration.max)
    text += ", from " + to_text(declaration.min) + " to " + to_text(declaration.max);
  return text;
}

/// The format of a value that has a unit, for printf.
std::string with_unit(const std::string& number, const std::string& unit) {
  std::string text = unit.empty() ? number : number + " " + unit;
  for (std::size_t at = number.size(); (at = text.find('%', at)) != std::string::npos; at += 2) text.insert(at, "%");
  return text;
}

/// As the text shows it.
float rounded_by(const char* format, float value) {
  char text[64];
  std::snprintf(text, sizeof text, format, static_cast<double>(value));
  const char* number = std::strpbrk(text, "+-.0123456789");
  return number ? std::strtof(number, nullptr) : value;
}

/// The control of one setting; true and the new value when it changed.
bool setting_control(const SettingDeclaration& declaration, SettingValue* value) {
  const bool wide = declaration.min > 0.0 && declaration.max / declaration.min > 50.0;
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | (wide ? ImGuiSliderFlags_Logarithmic : 0);
  const bool bounded = declaration.min != declaration.max;
  if (bool* flag = std::get_if<bool>(value)) return ImGui::Checkbox("##value", flag);
  if (int* number = std::get_if<int>(value)) {
    if (!bounded) return ImGui::DragInt("##value", number);
    auto real = static_cast<float>(*number);
    const std::string format = with_unit("%.0f", declaration.unit);
    const bool changed = slider("##value", &real, static_cast<float>(declaration.min),
                                static_cast<float>(declaration.max), format.c_str(), flags);
    if (changed) *number = static_cast<int>(std::lround(real));
    return changed;
  }
  if (double* number = std::get_if<double>(value)) {
    auto real = static_cast<float>(*number);
    const std::string format = with_unit("%.3g", declaration.unit);
    const bool changed = bounded ? slider("##value", &real, static_cast<float>(declaration.min),
                                          static_cast<float>(declaration.max), format.c_str(), flags)
                                 : ImGui::DragFloat("##value", &real, 0.01f, 0.0f, 0.0f, format.c_str());
    if (changed) *number = static_cast<double>(real);
    return changed;
  }
  auto& text = std::get<std::string>(*value);
  if (!declaration.choices.empty()) return combo("##value", &text, declaration.choices);
  char buffer[1024];
  std::snprintf(buffer, sizeof(buffer), "%s", text.c_str());
  if (!ImGui::InputText("##value", buffer, sizeof(buffer), ImGuiInputTextFlags_EnterReturnsTrue)) return false;
  text = buffer;
  return true;
}

}  // namespace

bool slider(const char* id, float* value, float low, float high, const char* format, ImGuiSliderFlags flags) {
  const float whole = ImGui::CalcItemWidth(), gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float column = std::clamp(whole - gap - scaled(40.0f), scaled(48.0f), scaled(88.0f));
  ImGui::BeginGroup();
  ImGui::SetNextItemWidth(std::max(whole - column - gap, scaled(16.0f)));
  const bool entered = ImGui::GetCurrentContext()->NavActivateInputId == ImGui::GetID(id);
  const bool typing = ImGui::GetIO().KeyCtrl || entered || ImGui::TempInputIsActive(ImGui::GetID(id));
  const bool changed = ImGui::SliderFloat(id, value, low, high, typing ? format : "", flags);
  if (changed) *value = rounded_by(format, *value);
  char text[64];
  std::snprintf(text, sizeof text, format, static_cast<double>(*value));
  ImGui::SameLine(0.0f, gap);
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(elide(text, column).c_str());
  const float rest = column - ImGui::GetItemRectSize().x;
  ImGui::SameLine(0.0f, 0.0f);
  ImGui::Dummy({std::max(rest, 0.0f), 1.0f});
  ImGui::EndGroup();
  // The group stands for the slider, also where the keyboard goes.
  ImGuiLastItemData& item = ImGui::GetCurrentContext()->LastItemData;
  item.ID = ImGui::GetID(id);
  item.InFlags |= ImGuiItemFlags_Inputable;
  return changed;
}

bool slider(const char* id, int* value, int low, int high, const char* format) {
  auto real = static_cast<float>(*value);
  const bool changed =
      slider(id, &real, static_cast<float>(low), static_cast<float>(high), format, ImGuiSliderFlags_AlwaysClamp);
  if (changed) *value = static_cast<int>(std::lround(real));
  return changed;
}

float scaled(float units) { return std::round(units * ImGui::GetFontSize() / kThemeFontSize); }

void mark_item(Ui& ui, const std::string& name) {
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ui.frame.items[name] = {a.x, a.y, b.x - a.x, b.y - a.y};
  const ImGuiLastItemData& item = ImGui::GetCurrentContext()->LastItemData;
  ImGuiWindow* window = ImGui::GetCurrentWindow();
  if (item.ID == 0 || (item.InFlags & ImGuiItemFlags_Disabled) != 0) return;
  if (!ui.frame.stops.empty() && ui.frame.stops.back().item == item.ID) return;  // marked by two names
  ui.frame.stops.push_back({item.ID,
                            window->ID,
                            window->RootWindow->Name,
                            {a.x, a.y, b.x - a.x, b.y - a.y},
                            (item.InFlags & ImGuiItemFlags_Inputable) != 0});
}

void press_by_enter(bool types) {
  ImGuiContext& context = *ImGui::GetCurrentContext();
  if (types || context.NavActivateInputId == 0 || context.ActiveId != 0) return;
  // A field that is given the keyboard is not pressed.
  if ((context.NavActivateFlags & ImGuiActivateFlags_TryToPreserveState) != 0) return;
  context.NavActivateId = context.NavActivateDownId = context.NavActivatePressedId = context.NavActivateInputId;
  context.NavActivateInputId = 0;
}

bool pressed_by_key() {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  return ImGui::GetItemID() != 0 && context.NavActivateId == ImGui::GetItemID();
}

void give_keyboard(const KeyboardStop& stop) {
  ImGuiContext& context = *ImGui::GetCurrentContext();
  ImGuiWindow* window = ImGui::FindWindowByID(stop.window);
  if (!window) return;
  ImGui::ClearActiveID();
  ImGui::FocusWindow(window);
  ImGui::SetFocusID(stop.item, window);
  const ImRect rect(stop.rect.x, stop.rect.y, stop.rect.x + stop.rect.width, stop.rect.y + stop.rect.height);
  window->NavRectRel[context.NavLayer] = {rect.Min - window->Pos, rect.Max - window->Pos};
  ImGui::ScrollToBringRectIntoView(window, rect);
  context.NavDisableHighlight = false;
  context.NavDisableMouseHover = true;
}

void take_keyboard(Ui& ui, const char* part) {
  if (ui.state.keyboard_goes_to != part || ui.frame.stops.empty()) return;
  ui.state.keyboard_goes_to.clear();
  give_keyboard(ui.frame.stops.back());
}

void tooltip(const std::string& text) {
  if (text.empty() || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(scaled(340.0f));
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void row_label(const char* label, const std::string& help) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored({0.72f, 0.72f, 0.74f, 1.0f}, "%s", label);
  tooltip(help);
  ImGui::SameLine(scaled(kLabelWidth) + ImGui::GetStyle().WindowPadding.x);
  ImGui::SetNextItemWidth(-FLT_MIN);
}

bool section(Ui& ui, const char* title, bool open) {
  ImGui::PushStyleColor(ImGuiCol_Header, ImVec4(0.175f, 0.175f, 0.182f, 1.0f));
  ImGui::PushStyleColor(ImGuiCol_HeaderActive, ImVec4(0.25f, 0.25f, 0.256f, 1.0f));
  const bool shown = ImGui::CollapsingHeader(title, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  ImGui::PopStyleColor(2);
  mark_item(ui, std::string("section/") + title);
  return shown;
}

bool toggle_button(const char* label, bool on) {
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, ImVec4(kAccent.x * 0.75f, kAccent.y * 0.75f, kAccent.z * 0.75f, 1.0f));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, kAccent);
  }
  const bool clicked = ImGui::Button(label);
  if (on) ImGui::PopStyleColor(2);
  return clicked;
}

std::string byte_text(std::size_t bytes) {
  char text[32];
  const double mib = static_cast<double>(bytes) / 1048576.0;
  std::snprintf(text, sizeof(text), mib < 10.0 ? "%.1f MiB" : "%.0f MiB", mib);
  return text;
}

void value_row(const char* label, const std::string& value) {
  ImGui::TextColored(kDim, "%s", label);
  ImGui::SameLine(ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(value.c_str()).x);
  ImGui::TextUnformatted(value.c_str());
}

void dim_text(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, kDim);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

bool begin_list(const char* id, float height, float width) {
  return ImGui::BeginChild(id, {width, height}, false, ImGuiWindowFlags_NavFlattened);
}

void hold_lines(float top_y, float lines) {
  ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), top_y + lines * ImGui::GetTextLineHeightWithSpacing()));
}

const char* glyph(const char* icon, const char* text) {
  // Two- and three-byte UTF-8 is all that the icons use.
  const auto* u = reinterpret_cast<const unsigned char*>(icon);
  const unsigned code = u[0] < 0x80   ? u[0]
                        : u[0] < 0xe0 ? (u[0] & 31u) << 6 | (u[1] & 63u)
                                      : (u[0] & 15u) << 12 | (u[1] & 63u) << 6 | (u[2] & 63u);
  return ImGui::GetFont()->FindGlyphNoFallback(static_cast<ImWchar>(code)) ? icon : text;
}

std::string elide(const std::string& text, float width) {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  std::size_t low = 0, high = text.size();
  while (low < high) {
    const std::size_t middle = (low + high + 1) / 2;
    if (ImGui::CalcTextSize((text.substr(0, middle) + "...").c_str()).x <= width)
      low = middle;
    else
      high = middle - 1;
  }
  while (low > 0 && (static_cast<unsigned char>(text[low]) & 0xc0u) == 0x80u) --low;  // not inside a UTF-8 letter
  return text.substr(0, low) + "...";
}

void number_fields(Ui& ui, const std::string& name, float* values, int count, const char* format) {
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x, n = static_cast<float>(count);
  const float width = std::floor((ImGui::GetContentRegionAvail().x - (n - 1.0f) * gap) / n);
  for (int i = 0; i < count; ++i) {
    if (i > 0) ImGui::SameLine(0.0f, gap);
    ImGui::SetNextItemWidth(width);
    ImGui::InputFloat(("##" + name + std::to_string(i)).c_str(), values + i, 0.0f, 0.0f, format);
    values[i] = std::clamp(values[i], -kMostTyped, kMostTyped);
    mark_item(ui, i == 0 ? name : name + "/" + std::to_string(i + 1));
  }
}

bool search_box(Ui& ui, const char* hint, char* text, std::size_t size) {
  ImGui::SetNextItemWidth(-FLT_MIN);
  ImGui::InputTextWithHint("##search", hint, text, size);
  mark_item(ui, hint);
  return text[0] != 0;
}

bool contains(const std::string& text, const char* part) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), part, part + std::strlen(part), same) != text.end() || *part == 0;
}

bool combo(const char* id, std::string* value, const std::vector<std::string>& names) {
  bool changed = false;
  if (!ImGui::BeginCombo(id, value->c_str())) return false;
  for (const std::string& name : names) {
    const bool selected = name == *value;
    if (ImGui::Selectable(name.c_str(), selected) && !selected) {
      *value = name;
      changed = true;
    }
    if (selected) ImGui::SetItemDefaultFocus();
  }
  ImGui::EndCombo();
  return changed;
}

void setting_row(Ui& ui, const SettingDeclaration& declaration) {
  ImGui::PushID(declaration.name.c_str());
  const std::string label = pretty(declaration.name);
  row_label(elide(label, scaled(kLabelWidth - 6.0f)).c_str(), full_help(declaration));
  const bool changed = ui.state.settings.changed().contains(declaration.name);
  const float reset_width = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x;
  ImGui::SetNextItemWidth(-reset_width);
  SettingValue value = ui.state.settings.get(declaration.name);
  if (setting_control(declaration, &value)) {
    try {
      ui.state.settings.set(declaration.name, value);
    } catch (const Error&) {
      // The control had a value out of range for a moment: the last valid one stays.
    }
  }
  tooltip(full_help(declaration));
  mark_item(ui, "setting/" + declaration.name);
  if (changed) {
    ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
    if (ImGui::Button(glyph("\u21ba", "x"), {ImGui::GetFrameHeight(), 0.0f})) ui.state.settings.reset(declaration.name);
    mark_item(ui, "reset/" + declaration.name);
    tooltip("Back to the default, " + to_text(declaration.default_value));
  }
  ImGui::PopID();
}

}  // namespace maquette::panels

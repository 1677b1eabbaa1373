#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "ui/widgets.h"

namespace maquette {

namespace {

constexpr float kFontSize = 15.0f;

/// Debian's fonts-dejavu-core first, then the paths of other systems.
const char* const kFontFiles[] = {
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
    "/usr/share/fonts/TTF/DejaVuSans.ttf",
    "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
    "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
};

// Latin, punctuation, arrows, geometric shapes, marks.
const ImWchar kGlyphRanges[] = {0x0020, 0x024f, 0x0370, 0x03ff, 0x2010, 0x2044, 0x2070, 0x209c, 0x2190, 0x2200,
                                0x2212, 0x2265, 0x25a0, 0x25ff, 0x2600, 0x26a1, 0x2713, 0x2717, 0};

void load_font(float scale) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  ImFontConfig config;
  config.OversampleH = 2;
  config.OversampleV = 1;
  config.PixelSnapH = true;
  const float size = std::round(kFontSize * scale);
  for (const char* file : kFontFiles) {
    std::error_code error;
    if (!std::filesystem::exists(file, error)) continue;
    if (atlas.AddFontFromFileTTF(file, size, &config, kGlyphRanges)) return;
  }
  config.SizePixels = size;
  atlas.AddFontDefault(&config);
}

ImVec4 gray(float value, float blue = 0.006f, float alpha = 1.0f) { return {value, value, value + blue, alpha}; }

void set_colors(ImGuiStyle* style) {
  ImVec4* c = style->Colors;
  const ImVec4 accent = panels::kAccent;
  const auto accent_at = [&](float alpha) { return ImVec4(accent.x, accent.y, accent.z, alpha); };
  c[ImGuiCol_Text] = gray(0.86f);
  c[ImGuiCol_TextDisabled] = gray(0.48f);
  c[ImGuiCol_WindowBg] = gray(0.135f);
  c[ImGuiCol_ChildBg] = gray(0.115f);
  c[ImGuiCol_PopupBg] = gray(0.165f);
  c[ImGuiCol_Border] = gray(0.24f);
  c[ImGuiCol_FrameBg] = gray(0.195f);
  c[ImGuiCol_FrameBgHovered] = gray(0.235f);
  c[ImGuiCol_FrameBgActive] = gray(0.26f);
  c[ImGuiCol_ScrollbarBg] = gray(0.115f, 0.006f, 0.0f);
  c[ImGuiCol_ScrollbarGrab] = gray(0.27f);
  c[ImGuiCol_ScrollbarGrabHovered] = gray(0.33f);
  c[ImGuiCol_ScrollbarGrabActive] = gray(0.4f);
  c[ImGuiCol_CheckMark] = accent;
  c[ImGuiCol_SliderGrab] = gray(0.36f);
  c[ImGuiCol_SliderGrabActive] = accent_at(0.8f);
  c[ImGuiCol_Button] = gray(0.215f);
  c[ImGuiCol_ButtonHovered] = gray(0.27f);
  c[ImGuiCol_ButtonActive] = gray(0.31f);
  c[ImGuiCol_Header] = accent_at(0.30f);
  c[ImGuiCol_HeaderHovered] = gray(0.23f);
  c[ImGuiCol_HeaderActive] = accent_at(0.42f);
  c[ImGuiCol_Separator] = gray(0.21f);
  c[ImGuiCol_Tab] = gray(0.135f);
  c[ImGuiCol_TabHovered] = gray(0.25f);
  c[ImGuiCol_TabActive] = gray(0.215f);
  c[ImGuiCol_TabUnfocused] = c[ImGuiCol_Tab];
  c[ImGuiCol_TabUnfocusedActive] = c[ImGuiCol_TabActive];
  c[ImGuiCol_PlotLines] = accent;
  c[ImGuiCol_PlotHistogram] = accent_at(0.85f);
  c[ImGuiCol_PlotHistogramHovered] = accent;
  c[ImGuiCol_TextSelectedBg] = accent_at(0.35f);
  c[ImGuiCol_NavHighlight] = {0.62f, 0.84f, 1.0f, 1.0f};
  c[ImGuiCol_TableHeaderBg] = gray(0.17f);
  c[ImGuiCol_TableRowBgAlt] = gray(1.0f, 0.0f, 0.02f);
}

}  // namespace

void apply_theme(float scale, float pixels_per_unit) {
  scale = std::clamp(scale, 0.5f, 6.0f);
  pixels_per_unit = std::clamp(pixels_per_unit, 0.5f, 6.0f);
  ImGui::GetIO().IniFilename = nullptr;  // the layout is fixed, nothing to remember
  ImGui::GetIO().ConfigWindowsMoveFromTitleBarOnly = true;
  ImGui::GetIO().ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  load_font(scale);
  ImGui::GetIO().FontGlobalScale = 1.0f / pixels_per_unit;
  ImGuiStyle style;
  set_colors(&style);
  style.WindowPadding = {10.0f, 10.0f};
  style.FramePadding = {7.0f, 4.0f};
  style.ItemSpacing = {7.0f, 6.0f};
  style.ItemInnerSpacing = {6.0f, 4.0f};
  style.IndentSpacing = 15.0f;
  style.ScrollbarSize = 11.0f;
  style.GrabMinSize = 8.0f;
  style.WindowRounding = 0.0f;
  style.ChildRounding = 4.0f;
  style.FrameRounding = 4.0f;
  style.PopupRounding = 5.0f;
  style.ScrollbarRounding = 6.0f;
  style.GrabRounding = 3.0f;
  style.TabRounding = 4.0f;
  style.WindowBorderSize = 0.0f;
  style.ChildBorderSize = 0.0f;
  style.PopupBorderSize = 1.0f;
  style.ScaleAllSizes(scale / pixels_per_unit);
  style.PopupBorderSize = 1.0f;
  style.WindowMinSize = {1.0f, 1.0f};
  ImGui::GetStyle() = style;
}

}  // namespace maquette

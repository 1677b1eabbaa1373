#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "ui/editor.h"
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

/// For what the first font lacks: Chinese, Japanese, Korean. Debian's fonts-noto-cjk has all of it;
/// fonts-droid-fallback and fonts-nanum (Korean) are small.
const char* const kFurtherFontFiles[] = {
    "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
    "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
    "/usr/share/fonts/truetype/nanum/NanumGothic.ttf",
    "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
    "/usr/share/fonts/noto-cjk/NotoSansCJK-Regular.ttc",
};

// Latin, Greek, Cyrillic, Vietnamese, punctuation, arrows, geometric shapes, marks.
const ImWchar kGlyphRanges[] = {0x0020, 0x024f, 0x0370, 0x052f, 0x1e00, 0x1eff, 0x2010, 0x2044,
                                0x2070, 0x209c, 0x20ab, 0x20ac, 0x2190, 0x2200, 0x2212, 0x2265,
                                0x25a0, 0x25ff, 0x2600, 0x26a1, 0x2713, 0x2717, 0};

/// kGlyphRanges and further characters one by one; ImGui reads it until the atlas is built.
const std::vector<ImWchar>& ranges_with(const std::set<char16_t>& further) {
  static std::vector<ImWchar> ranges;
  ranges.assign(std::begin(kGlyphRanges), std::end(kGlyphRanges) - 1);
  for (const char16_t c : further) ranges.insert(ranges.end(), 2, c);
  ranges.push_back(0);
  return ranges;
}

/// With as many of the files as `further` needs; those of it that none of them has.
std::set<char16_t> load_font(float scale, const std::set<char16_t>& further) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  const auto is_there = [](const char* file) {
    std::error_code error;
    return std::filesystem::exists(file, error);
  };
  std::vector<const char*> files;
  for (const char* file : kFontFiles)
    if (files.empty() && is_there(file)) files.push_back(file);
  const std::vector<ImWchar>& ranges = ranges_with(further);
  std::set<char16_t> missing;
  for (auto next = std::begin(kFurtherFontFiles);; ++next) {
    atlas.Clear();
    ImFontConfig config;
    config.OversampleH = 2;
    config.OversampleV = 1;
    config.PixelSnapH = true;
    config.SizePixels = std::round(kFontSize * scale);
    for (const char* file : files) {
      config.MergeMode = !atlas.Fonts.empty();
      atlas.AddFontFromFileTTF(file, config.SizePixels, &config, ranges.data());
    }
    config.MergeMode = false;
    if (atlas.Fonts.empty()) atlas.AddFontDefault(&config);
    if (further.empty()) return {};
    atlas.Build();
    missing.clear();
    for (const char16_t c : further)
      if (!atlas.Fonts[0]->FindGlyphNoFallback(c)) missing.insert(c);
    next = std::find_if(next, std::end(kFurtherFontFiles), is_there);
    if (missing.empty() || next == std::end(kFurtherFontFiles)) return missing;
    files.push_back(*next);
  }
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

std::set<char16_t> apply_theme(float scale, float pixels_per_unit, const std::set<char16_t>& further) {
  scale = std::clamp(scale, 0.5f, 6.0f);
  pixels_per_unit = std::clamp(pixels_per_unit, 0.5f, 6.0f);
  ImGui::GetIO().IniFilename = nullptr;  // the layout is fixed, nothing to remember
  ImGui::GetIO().ConfigWindowsMoveFromTitleBarOnly = true;
  ImGui::GetIO().ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  std::set<char16_t> missing = load_font(scale, further);
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
  return missing;
}

}  // namespace maquette

#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "render/technique/settings.h"
#include "ui/editor.h"

/// Pieces that the panels share. Internal to ui/.
namespace maquette::panels {

/// Arguments of every panel.
struct Ui {
  EditorState& state;
  const EditorFacts& facts;
  EditorActions& actions;
  EditorFrame& frame;
};

/// Length in units of the theme's scale (1 at 96 dpi).
float scaled(float units);
extern const ImVec4 kDim, kAccent, kWarning, kError;

/// Records the rectangle of the last item under a name; the keyboard comes to it in this order.
void mark_item(Ui& ui, const std::string& name);
/// Shows an explanation of the last item when the mouse rests on it.
void tooltip(const std::string& text);
/// "Name ......" on the left; the next control fills the rest of the row.
void row_label(const char* label, const std::string& help = {});
/// Small grey caps-free heading with a rule; true when open.
bool section(Ui& ui, const char* title, bool open = true);
void dim_text(const std::string& text);
/// What follows begins at least so many lines of text below `top_y`, a cursor position: nothing jumps when text comes
/// or goes.
void hold_lines(float top_y, float lines);
/// Label on the left, value on the right.
void value_row(const char* label, const std::string& value);
/// In MiB.
std::string byte_text(std::size_t bytes);
/// A button that is highlighted while its state is on; true when clicked.
bool toggle_button(const char* label, bool on);
/// `icon` where the font has it, else `text`.
const char* glyph(const char* icon, const char* text);
/// Text cut to `width` with an ellipsis.
std::string elide(const std::string& text, float width);
/// A part of a panel that scrolls by itself, to the bottom where its height is 0; ends with ImGui::EndChild. The
/// keyboard walks in and out of it.
bool begin_list(const char* id, float height, float width = 0.0f);
/// Search field over the whole width, marked by its hint; true when it has text.
bool search_box(Ui& ui, const char* hint, char* text, std::size_t size);
/// Case-insensitive.
bool contains(const std::string& text, const char* part);
/// Combo over names; true when `value` changed.
bool combo(const char* id, std::string* value, const std::vector<std::string>& names);
/// A slider whose value stands beside it, as printf's `format` writes and rounds it; Ctrl+click types one. Takes the
/// width that was set for the next item.
bool slider(const char* id, float* value, float low, float high, const char* format, ImGuiSliderFlags flags = 0);
/// Of whole numbers; the format is that of a float without decimals.
bool slider(const char* id, int* value, int low, int high, const char* format = "%.0f");
/// Fields for some numbers in a row, over the rest of it.
void number_fields(Ui& ui, const std::string& name, float* values, int count, const char* format);
/// Slider, combo or box made from the declaration, with its unit, its help, and a reset button if it was changed.
void setting_row(Ui& ui, const SettingDeclaration& declaration);

/// At the begin of a frame: Enter presses what has the keyboard, as Space does, unless `types`: there it begins to
/// type.
void press_by_enter(bool types);
/// The last item was pressed by Space or Enter.
bool pressed_by_key();
/// Gives a control the keyboard, visibly.
void give_keyboard(const KeyboardStop& stop);
/// Gives the item that was marked last the keyboard, visibly, when it is to go to this part of the window.
void take_keyboard(Ui& ui, const char* part);

void draw_toolbar(Ui& ui);
void draw_menu(Ui& ui);  ///< button and popup with all commands
void draw_status(Ui& ui);
/// Recent and built-in scenes, over the picture.
void draw_start_popup(Ui& ui);
void draw_strip(Ui& ui);
float strip_height(const EditorFacts& facts, float width);
void draw_materials_panel(Ui& ui);
/// What was dragged from the library and let go over the picture or over a material in this frame; else empty.
std::string dropped_source(const Ui& ui);
void draw_scene_panel(Ui& ui);
void draw_help_panel(Ui& ui);
void draw_review_panel(Ui& ui);
void draw_timeline(Ui& ui, CameraPath* path);  ///< its bar of keys
void draw_look_panel(Ui& ui);
void draw_render_panel(Ui& ui);
void draw_frame_panel(Ui& ui);
void draw_bakes(Ui& ui);
/// What the picture gains when a bake is done; empty: nobody knows.
std::string change_text(const Registry& registry, const std::string& bake, bool last_is_shown);
std::string time_left_text(double seconds);
void draw_error_panel(Ui& ui);
void draw_inspection_panel(Ui& ui);
void draw_stored_light(Ui& ui);  ///< its section on what bakes store
/// Names and values, one below the other.
void draw_rows(const std::vector<std::pair<std::string, std::string>>& rows);

}  // namespace maquette::panels

#include "viewer/window_compare.h"

#include <imgui.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "render/metrics/flip.h"
#include "render/picture/tonemap.h"
#include "render/views/false_color.h"
#include "review/journal.h"
#include "scenes/error.h"
#include "scenes/file_name.h"
#include "scenes/image_io.h"
#include "viewer/overlay_texture.h"
#include "viewer/picture_command.h"

namespace maquette {

namespace fs = std::filesystem;

namespace {

constexpr int kAveraged = 4, kAveragedSmooth = 16, kAveragedFile = 16;  // frames
constexpr float kWiperReach = 7.0f;                                     // units to each side of the line

/// A file in a folder that is not there yet: NAME.exr, NAME 2.exr, ...
std::string free_file(const fs::path& folder, const std::string& look, const std::string& ending) {
  const std::string name = readable_file_name(look);
  fs::path file = folder / (name + ending);
  for (int number = 2; fs::exists(file); ++number) file = folder / (name + " " + std::to_string(number) + ending);
  return file.string();
}

const Look* kept_look(const EditorState& state, const std::string& name) {
  const auto found = std::ranges::find(state.looks, name, &Look::name);
  return found == state.looks.end() ? nullptr : &*found;
}

/// A look that is left for another is kept first, unless it is a kept one by another camera.
void keep_present(EditorState* state) {
  Look present = canonical(*state);
  if (const Look* kept = kept_look(*state, state->name)) {
    Look moved = *kept;
    moved.camera = present.camera;
    if (moved == present) return;
  }
  present.name = state->name = free_name(state->looks, state->name.empty() ? "A" : state->name);
  state->looks.push_back(present);
}

void label(ImDrawList* list, const ImVec2& at, const std::string& text) {
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  list->AddRectFilled({at.x - 4.0f, at.y - 2.0f}, {at.x + size.x + 4.0f, at.y + size.y + 2.0f}, IM_COL32(0, 0, 0, 150),
                      3.0f);
  list->AddText(at, IM_COL32(255, 255, 255, 230), text.c_str());
}

}  // namespace

void WindowCompare::note_looks(const EditorState& state) {
  if (state.name == present_) return;
  if (kept_look(state, present_)) other_ = present_;
  present_ = state.name;
}

/// The one that was chosen; else the look that was shown before; without one, any other.
const Look* WindowCompare::find_other(EditorState* state) {
  note_looks(*state);
  CompareView& view = state->compare;
  if (view.other == state->name || !kept_look(*state, view.other)) view.other.clear();
  if (!view.other.empty()) return kept_look(*state, view.other);
  if (other_ == state->name || !kept_look(*state, other_)) {
    const auto any = std::ranges::find_if(state->looks, [&](const Look& look) { return look.name != state->name; });
    other_ = any == state->looks.end() ? "" : any->name;
  }
  return kept_look(*state, other_);
}

void WindowCompare::toggle(WindowSession* session) {
  EditorState& state = session->state;
  state.compare.on = !state.compare.on;
  if (!state.compare.on) stop(&state);
}

void WindowCompare::swap(WindowSession* session) {
  EditorState& state = session->state;
  const Look* found = find_other(&state);
  if (!found) return;
  Look other = *found;
  keep_present(&state);
  other.camera = state.camera;
  const std::string present = state.name;
  note_looks(state);
  session->take(other);
  note_looks(state);
  if (!state.compare.other.empty()) state.compare.other = present;
}

void WindowCompare::render_file(WindowSession* session, const WindowPicture& picture) {
  SettledFrame settled;
  settled.size.width = picture.drawn_size().x;
  settled.size.height = picture.drawn_size().y;
  settled.frames = kAveragedFile;
  start_file(session, settled, ".exr");
}

void WindowCompare::save_picture(WindowSession* session) {
  const PictureFile& file = session->state.picture_file;
  SettledFrame settled;
  settled.size.width = file.width;
  settled.size.height = file.height;
  settled.size.msaa = file.msaa;
  settled.frames = file.frames;
  start_file(session, settled, file.png ? ".png" : ".exr");
}

void WindowCompare::cancel_picture(WindowSession* session) {
  if (!file_.busy()) return;
  file_.cancel();
  session->add_message(MessageLevel::warning, "cancelled: " + file_.output());
}

std::optional<BackgroundWork> WindowCompare::picture_in_work() const {
  if (!file_.busy()) return std::nullopt;
  return BackgroundWork{fs::path(file_.output()).filename().string(), file_.progress()};
}

void WindowCompare::start_file(WindowSession* session, const SettledFrame& settled, const std::string& ending) {
  if (file_.busy()) return session->add_message(MessageLevel::warning, file_.output() + " is still in work");
  try {
    const std::string& review = session->review().file();
    const std::string& name = session->state.name;
    const std::string file = free_file(review.empty() ? fs::current_path() : fs::path(review).parent_path(),
                                       name.empty() ? "look" : name, ending);
    const std::optional<std::string> command = repeating_command(session->review(), settled, file);
    again_ = command ? "again by: " + *command
                     : "to draw it again by a command, keep the look (L) and save the review (Ctrl+S) first";
    file_.start(session->review().review(), settled, file, command.value_or(""));
    session->add_message(MessageLevel::warning, "in work: " + file_.output());
  } catch (const Error& error) {
    session->add_message(MessageLevel::error, error.what());
  }
}

bool WindowCompare::takes(const PointerEvent& event, const EditorState& state, const Rect& picture) {
  using Kind = PointerEvent::Kind;
  const float line = picture.x + wiper_ * picture.width;
  const bool wipes = state.compare.on && state.compare.how == CompareView::How::wiper;
  if (event.kind == Kind::press && wipes && event.button == 0 && picture.contains(event.x, event.y) &&
      std::abs(event.x - line) <= kWiperReach)
    dragging_ = true;
  if (!dragging_) return false;
  wiper_ = std::clamp((event.x - picture.x) / std::max(picture.width, 1.0f), 0.0f, 1.0f);
  if (event.kind == Kind::release) dragging_ = false;
  return true;
}

void WindowCompare::stop(EditorState* state) {
  state->compare.on = ready_ = dragging_ = false;
  state->compare.other.clear();
  drawing_.cancel();
  wanted_.reset();
}

void WindowCompare::update(WindowSession* session, const WindowPicture& picture) {
  std::string error;
  if (file_.poll(&error))
    session->add_message(error.empty() ? MessageLevel::warning : MessageLevel::error,
                         error.empty() ? "written: " + file_.output() + "; " + again_ : error);
  EditorState& state = session->state;
  note_looks(state);
  if (!state.compare.on) {
    if (wanted_) stop(&state);
    return;
  }
  const Look* other = find_other(&state);
  if (!other) {
    session->add_message(MessageLevel::warning, "Compare: there is no other look; L keeps the present one");
    return stop(&state);
  }
  try {
    draw_other(session, picture, *other);
    if (ready_ && wanted_->look.auto_exposure && shown_ev_ != state.exposure_ev) show(state.exposure_ev);
    if (state.compare.how == CompareView::How::difference) take_difference(session, picture);
  } catch (const Error& problem) {
    session->add_message(MessageLevel::error, problem.what());
    stop(&state);
  }
}

void WindowCompare::draw_other(WindowSession* session, const WindowPicture& picture, const Look& other) {
  Wanted wanted{other, picture.drawn_size().x, picture.drawn_size().y};
  wanted.look.camera = session->state.camera;
  wanted.look.edits.section = session->state.edits.section;
  const bool known = wanted_ && *wanted_ == wanted;
  if (!known) {
    ready_ = false;
    mean_flip_ = -1.0;
    drawing_.cancel();
  }
  // Once the present picture has smooth edges the other one gets them too: a difference would show them as dots.
  const int msaa = std::max(picture.drawn().msaa, known ? wanted_msaa_ : 1);
  const bool smoother = known && msaa > wanted_msaa_ && !drawing_.busy();
  if ((!known || smoother) && picture.still()) {
    Review review = session->review().review();
    review.look = wanted.look;
    SettledFrame settled;
    settled.size.width = wanted.width;
    settled.size.height = wanted.height;
    settled.size.msaa = msaa;
    settled.frames = smoother ? kAveragedSmooth : kAveraged;
    drawing_.start(review, settled, state_folder() + "/compare-" + std::to_string(::getpid()) + ".exr");
    wanted_ = wanted;
    wanted_msaa_ = msaa;
  }
  std::string error;
  if (!drawing_.poll(&error)) return;
  if (!error.empty()) throw Error("", error);
  radiance_ = load_hdr_image(drawing_.output());
  fs::remove(drawing_.output());
  ready_ = true;
  show(session->state.exposure_ev);
}

/// Computed beside the window, anew each time that the average has twice as many frames.
void WindowCompare::take_difference(WindowSession* session, const WindowPicture& picture) {
  if (comparing_.valid() && comparing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const Difference found = comparing_.get();
    difference_ = overlay_texture(found.picture, "difference of looks", GL_NEAREST);
    mean_flip_ = found.mean;
  }
  const int frames = picture.still() ? picture.stats()->accumulated_frames : 0;
  const bool same_size = picture.drawn_size() == glm::ivec2(display_.width, display_.height);
  if (!ready_ || comparing_.valid() || frames == 0 || !same_size) return;
  if (frames >= compared_frames_ && frames < 2 * compared_frames_) return;
  compared_frames_ = frames;
  const EditorState& state = session->state;
  Image own = tone_map(session->renderer().read_radiance(), state.exposure_ev, state.tonemap);
  comparing_ = std::async(std::launch::async, [own = std::move(own), other = display_]() mutable {
    const auto linear = [](Image* image) {
      for (float& v : image->data) v = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
    };
    linear(&own);
    linear(&other);
    const Image map = flip_ldr_map(own, other);
    Difference difference{false_color_image(map, FalseColorRange{0.0f, 1.0f}), 0.0};
    for (const float v : map.data) difference.mean += static_cast<double>(v);
    difference.mean /= static_cast<double>(std::max<std::size_t>(map.data.size(), 1));
    return difference;
  });
}

/// `exposure_ev`: of the present look, which one that is metered shares.
void WindowCompare::show(float exposure_ev) {
  shown_ev_ = exposure_ev;
  const Look& look = wanted_->look;
  display_ = tone_map(radiance_, look.auto_exposure ? exposure_ev : look.exposure_ev, look.tonemap);
  for (std::size_t i = 3; i < display_.data.size(); i += 4) display_.data[i] = 1.0f;
  texture_ = overlay_texture(display_, "other look", GL_LINEAR);
  compared_frames_ = 0;
}

namespace {

/// Both pictures whole, each half as large.
void draw_halves(ImDrawList* list, ImTextureID own, ImTextureID other, const Rect& rect) {
  const float bottom = rect.y + rect.height, middle = rect.x + 0.5f * rect.width, top = rect.y + 0.25f * rect.height;
  list->AddRectFilled({rect.x, rect.y}, {rect.x + rect.width, bottom}, IM_COL32(20, 20, 22, 255));
  list->AddImage(own, {rect.x, top}, {middle - 1.0f, bottom - 0.25f * rect.height}, {0.0f, 1.0f}, {1.0f, 0.0f});
  if (other) list->AddImage(other, {middle + 1.0f, top}, {rect.x + rect.width, bottom - 0.25f * rect.height});
}

/// As much of the name as there is room for.
std::string fitted(std::string name, float room) {
  const auto wide = [&](const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x > room; };
  if (!wide(name)) return name;
  while (name.size() > 1 && wide(name + "...")) name.pop_back();
  while (!name.empty() && (static_cast<unsigned char>(name.back()) & 0xc0u) == 0x80u) name.pop_back();  // UTF-8
  return name + "...";
}

/// Both names beside the line at x, inside the picture: a side that has no room has no name.
void draw_names(ImDrawList* list, const std::string& present, const std::string& other, float x, const Rect& rect) {
  constexpr float kGap = 10.0f, kEdge = 6.0f, kLeast = 40.0f;
  const float y = rect.y + rect.height - 1.6f * ImGui::GetFontSize();
  const float left = x - kGap - rect.x - kEdge, right = rect.x + rect.width - kEdge - x - kGap;
  if (right >= kLeast) label(list, {x + kGap, y}, fitted(other, right));
  if (left < kLeast) return;
  const std::string shown = fitted(present, left);
  label(list, {x - kGap - ImGui::CalcTextSize(shown.c_str()).x, y}, shown);
}

}  // namespace

void WindowCompare::draw_overlay(const EditorState& state, const WindowPicture& picture, const Rect& rect) const {
  if (!state.compare.on || rect.empty() || !picture.shown()) return;
  using How = CompareView::How;
  const How how = state.compare.how;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const float bottom = rect.y + rect.height, middle = rect.y + 0.5f * rect.height;
  const std::string present = "A  " + (state.name.empty() ? std::string("as it is") : state.name);
  std::string other = "B  " + (state.compare.other.empty() ? other_ : state.compare.other);
  float x = rect.x + 0.5f * rect.width;
  if (how == How::side_by_side) {
    draw_halves(list, texture_id(picture.shown()), ready_ ? texture_id(texture_) : ImTextureID(), rect);
  } else if (how == How::wiper) {
    x = rect.x + wiper_ * rect.width;
    if (ready_)
      list->AddImage(texture_id(texture_), {x, rect.y}, {rect.x + rect.width, bottom}, {wiper_, 0.0f}, {1.0f, 1.0f});
    list->AddLine({x, rect.y}, {x, bottom}, IM_COL32(255, 255, 255, 200), 2.0f);
    list->AddRectFilled({x - 5.0f, middle - 18.0f}, {x + 5.0f, middle + 18.0f}, IM_COL32(255, 255, 255, 230), 5.0f);
  } else if (ready_ && mean_flip_ >= 0.0) {
    list->AddImage(texture_id(difference_), {rect.x, rect.y}, {rect.x + rect.width, bottom});
  }
  draw_names(list, present, other, x, rect);
  if (how != How::difference && ready_) return;
  char text[96];
  std::snprintf(text, sizeof text,
                !ready_            ? "B is being drawn"
                : mean_flip_ < 0.0 ? "is being compared"
                                   : "FLIP, mean %.4f: 0 blue, 1 red",
                mean_flip_);
  label(list, {x - 0.5f * ImGui::CalcTextSize(text).x, rect.y + 0.6f * ImGui::GetFontSize()}, text);
}

}  // namespace maquette

#include "viewer/window_compare.h"

#include <imgui.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/picture/tonemap.h"
#include "review/journal.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "viewer/overlay_texture.h"

namespace maquette {

namespace fs = std::filesystem;

namespace {

constexpr int kAveraged = 4, kAveragedFile = 16;  // frames
constexpr float kWiperReach = 7.0f;               // units to each side of the line

/// A file in a folder that is not there yet: NAME.exr, NAME 2.exr, ...
std::string free_file(const fs::path& folder, std::string name) {
  std::replace(name.begin(), name.end(), '/', '-');
  fs::path file = folder / (name + ".exr");
  for (int number = 2; fs::exists(file); ++number) file = folder / (name + " " + std::to_string(number) + ".exr");
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

/// The look that was shown before; without one, any other.
const Look* WindowCompare::find_other(const EditorState& state) {
  note_looks(state);
  if (other_ == state.name || !kept_look(state, other_)) {
    const auto any = std::ranges::find_if(state.looks, [&](const Look& look) { return look.name != state.name; });
    other_ = any == state.looks.end() ? "" : any->name;
  }
  return kept_look(state, other_);
}

void WindowCompare::toggle(WindowSession* session) {
  if (on_) return stop();
  on_ = find_other(session->state) != nullptr;
  if (!on_) session->add_message(MessageLevel::warning, "Compare: there is no other look; L keeps the present one");
}

void WindowCompare::swap(WindowSession* session) {
  EditorState& state = session->state;
  const Look* found = find_other(state);
  if (!found) return;
  Look other = *found;
  keep_present(&state);
  other.camera = state.camera;
  note_looks(state);
  session->take(other);
  note_looks(state);
}

void WindowCompare::render_file(WindowSession* session, const WindowPicture& picture) {
  if (file_.busy()) return session->add_message(MessageLevel::warning, file_.output() + " is still in work");
  try {
    const std::string& review = session->review().file();
    SettledFrame settled;
    settled.size.width = picture.drawn_size().x;
    settled.size.height = picture.drawn_size().y;
    settled.frames = kAveragedFile;
    const std::string& name = session->state.name;
    file_.start(
        session->review().review(), settled,
        free_file(review.empty() ? fs::current_path() : fs::path(review).parent_path(), name.empty() ? "look" : name));
    session->add_message(MessageLevel::warning, "in work: " + file_.output());
  } catch (const Error& error) {
    session->add_message(MessageLevel::error, error.what());
  }
}

bool WindowCompare::takes(const PointerEvent& event, const Rect& picture) {
  using Kind = PointerEvent::Kind;
  const float line = picture.x + wiper_ * picture.width;
  if (event.kind == Kind::press && on_ && event.button == 0 && picture.contains(event.x, event.y) &&
      std::abs(event.x - line) <= kWiperReach)
    dragging_ = true;
  if (!dragging_) return false;
  wiper_ = std::clamp((event.x - picture.x) / std::max(picture.width, 1.0f), 0.0f, 1.0f);
  if (event.kind == Kind::release) dragging_ = false;
  return true;
}

void WindowCompare::stop() {
  on_ = ready_ = dragging_ = false;
  drawing_.cancel();
  wanted_.reset();
}

void WindowCompare::update(WindowSession* session, const WindowPicture& picture) {
  std::string error;
  if (file_.poll(&error))
    session->add_message(error.empty() ? MessageLevel::warning : MessageLevel::error,
                         error.empty() ? "written: " + file_.output() : error);
  const EditorState& state = session->state;
  note_looks(state);
  if (!on_) return;
  const Look* other = find_other(state);
  if (!other) return stop();
  Wanted wanted{*other, picture.drawn_size().x, picture.drawn_size().y};
  wanted.look.camera = state.camera;
  const bool known = wanted_ && *wanted_ == wanted;
  if (!known) {
    ready_ = false;
    drawing_.cancel();
  }
  try {
    if (!known && picture.still()) {
      Review review = session->review().review();
      review.look = wanted.look;
      SettledFrame settled;
      settled.size.width = wanted.width;
      settled.size.height = wanted.height;
      settled.frames = kAveraged;
      drawing_.start(review, settled, state_folder() + "/compare-" + std::to_string(::getpid()) + ".exr");
      wanted_ = wanted;
    }
    if (drawing_.poll(&error)) {
      if (!error.empty()) throw Error("", error);
      radiance_ = load_hdr_image(drawing_.output());
      fs::remove(drawing_.output());
      ready_ = true;
      show(state.exposure_ev);
    }
  } catch (const Error& problem) {
    session->add_message(MessageLevel::error, problem.what());
    stop();
  }
  if (ready_ && wanted_->look.auto_exposure && shown_ev_ != state.exposure_ev) show(state.exposure_ev);
}

/// `exposure_ev`: of the present look, which one that is metered shares.
void WindowCompare::show(float exposure_ev) {
  shown_ev_ = exposure_ev;
  const Look& look = wanted_->look;
  Image display = tone_map(radiance_, look.auto_exposure ? exposure_ev : look.exposure_ev, look.tonemap);
  for (std::size_t i = 3; i < display.data.size(); i += 4) display.data[i] = 1.0f;
  texture_ = overlay_texture(display, "other look", GL_LINEAR);
}

void WindowCompare::draw_overlay(const EditorState& state, const Rect& picture) const {
  if (!on_ || picture.empty()) return;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const float x = picture.x + wiper_ * picture.width;
  const float bottom = picture.y + picture.height, middle = picture.y + 0.5f * picture.height;
  if (ready_)
    list->AddImage(texture_id(texture_), {x, picture.y}, {picture.x + picture.width, bottom}, {wiper_, 0.0f},
                   {1.0f, 1.0f});
  list->AddLine({x, picture.y}, {x, bottom}, IM_COL32(255, 255, 255, 200), 2.0f);
  list->AddRectFilled({x - 5.0f, middle - 18.0f}, {x + 5.0f, middle + 18.0f}, IM_COL32(255, 255, 255, 230), 5.0f);
  const float y = bottom - 1.6f * ImGui::GetFontSize();
  const std::string present = "A  " + (state.name.empty() ? std::string("as it is") : state.name);
  label(list, {x + 10.0f, y}, "B  " + other_ + (ready_ ? "" : " (is being drawn)"));
  label(list, {x - 10.0f - ImGui::CalcTextSize(present.c_str()).x, y}, present);
}

}  // namespace maquette

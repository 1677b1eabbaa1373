#include "viewer/window.h"

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/context.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "ui/editor.h"
#include "ui/glyphs.h"
#include "ui/shortcuts.h"
#include "viewer/bake_clock.h"
#include "viewer/swatches.h"
#include "viewer/window_compare.h"
#include "viewer/window_host.h"
#include "viewer/window_input.h"
#include "viewer/window_inspection.h"
#include "viewer/window_memory.h"
#include "viewer/window_meter.h"
#include "viewer/window_overlays.h"
#include "viewer/window_paths.h"
#include "viewer/window_picture.h"
#include "viewer/window_session.h"
#include "viewer/window_state.h"
#include "viewer/window_stored_light.h"
#include "viewer/window_thumbnails.h"

namespace maquette {

namespace {

constexpr double kPollWait_s = 1.0 / 60.0;
constexpr double kRestWait_s = 0.1;
constexpr double kBusyMouse_s = 0.15;  // the picture waits for this time after the mouse has moved over panels

/// The program while its window is open.
class App {
 public:
  App(const SceneOptions& options, const WindowMemory& memory, GlfwWindow* window, Inbox* inbox)
      : options_(options),
        memory_(memory),
        glfw_(window),
        window_(window->get()),
        inbox_(inbox),
        host_(window->get()),
        session_(options) {
    const DeviceInfo device = query_device();
    facts_.device = device.renderer;
    EditorState& state = session_.state;
    state.left_open = memory.left_open;
    state.right_open = memory.right_open;
    state.text_scale = memory.text_scale;
    state.start_popup = options.screenshot.empty() && options.review.empty() && !options.given.contains("SCENE");
    last_frame_s_ = glfwGetTime();
  }

  int run() {
    while (!glfwWindowShouldClose(window_)) {
      wait();
      frame();
      if (shot_wanted_) take_screenshot();
      if (!options_.screenshot.empty() && drawn_frames_ >= std::max(options_.frames, 1)) {
        save_screenshot(options_.screenshot);
        glfwSwapBuffers(window_);
        break;
      }
      glfwSwapBuffers(window_);
      ++shown_frames_;
      if (!state_file_.empty()) tell_state();
    }
    remember();
    return 0;
  }

 private:
  void wait() {
    const double now = glfwGetTime();
    const bool busy_mouse = now - inbox_->last_event_s < kBusyMouse_s;
    if (picture_.resting(now) && !busy_mouse && !paths_.playing())
      glfwWaitEventsTimeout(kRestWait_s);
    else if (!drew_ && inbox_->empty())
      glfwWaitEventsTimeout(kPollWait_s);
    else
      glfwPollEvents();
  }

  void frame() {
    const double now = glfwGetTime();
    const EditorState& state = session_.state;
    // Keys wait for what they are meant for.
    const bool opens = state.open_path_popup || state.save_path_popup || state.start_popup || state.menu_popup ||
                       editor_.awaits_field || !state.keyboard_goes_to.empty() || state.keyboard_step != 0;
    const InputBatch input = inbox_->next(editor_.typing, opens);
    host_.set_text_scale(state.text_scale);
    host_.begin_frame(input);
    collect_facts();
    glyphs_.note(state, facts_);
    host_.set_glyphs(glyphs_.all());
    say_missing_glyphs();
    EditorActions actions;
    editor_ = draw_editor(&session_.state, facts_, &actions);
    if (input.typing)
      leave_field(input.keys);
    else
      handle_keys(input.keys, &actions);
    for (const Command command : actions.commands) {
      request(command, &actions);
      change_view(command);
    }
    handle_pointer(input.pointer);
    fly(static_cast<float>(now - last_frame_s_));
    last_frame_s_ = now;
    for (const std::string& path : inbox_->dropped) session_.open(path, material_under_mouse());
    inbox_->dropped.clear();
    if (!actions.drop_source.empty()) drop(actions.drop_source);
    carry_out(actions);
    paths_.carry_out(actions, &session_, now);
    paths_.update(&session_, now);
    session_.update(editor_.editing || input_.dragging() || paths_.playing(), now);
    draw(now);
    meter_.update(&session_, picture_, now);
    meter_.draw_overlay(session_, editor_.layout.picture);
    double x = 0.0, y = 0.0;
    glfwGetCursorPos(window_, &x, &y);
    inspection_.update(&session_, picture_, editor_.layout.picture, {static_cast<float>(x), static_cast<float>(y)},
                       now);
    inspection_.draw_overlay(session_, editor_.layout.picture);
    stored_light_.update(&session_, picture_);
    compare_.update(&session_, picture_);
    compare_.draw_overlay(session_.state, picture_, editor_.layout.picture);
    draw_distance(session_.state, session_.bounds(), editor_.layout.picture);
    thumbnails_.update(session_, picture_.still() && !compare_.drawing() && !session_.loading());
    note_file();
    host_.end_frame();
  }

  /// For programs that wait for what they asked.
  void tell_state() {
    WindowState state;
    state.frames = shown_frames_;
    state.pictures = drawn_frames_;
    state.averaged = picture_.stats() ? picture_.stats()->accumulated_frames : 0;
    state.still = picture_.still();
    state.waiting = inbox_->waiting();
    for (const BackgroundWork& work : session_.renderer().background_work()) state.work.push_back(work.what);
    if (const auto file = compare_.picture_in_work()) state.work.push_back(file->what);
    if (session_.loading()) state.work.emplace_back("loading");
    write_window_state(state_file_, state);
  }

  void draw(double now) {
    int width = 0, height = 0, window_width = 0, window_height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    glfwGetWindowSize(window_, &window_width, &window_height);
    if (width < 1 || height < 1 || window_width < 1 || window_height < 1) return;  // minimised
    const float sx = static_cast<float>(width) / static_cast<float>(window_width);
    const float sy = static_cast<float>(height) / static_cast<float>(window_height);
    const Rect& rect = editor_.layout.picture;
    const int x = static_cast<int>(std::lround(rect.x * sx)), y = static_cast<int>(std::lround(rect.y * sy));
    const int w = std::max(static_cast<int>(std::lround(rect.width * sx)), 1);
    const int h = std::max(static_cast<int>(std::lround(rect.height * sy)), 1);
    PictureUpdate update;
    update.width_px = w;
    update.height_px = h;
    const bool mouse = now - inbox_->last_event_s < kBusyMouse_s && options_.screenshot.empty();
    update.panels_busy = mouse || meter_.comparing() || (compare_.drawing() && picture_.still());
    update.playing = paths_.playing();
    update.more_events = !inbox_->empty();
    update.now_s = now;
    // Panels come first: the programs of a first picture take seconds where the driver has not kept them.
    const bool panels_alone = !std::exchange(shown_, true);
    drew_ = !panels_alone && picture_.update(&session_, update);
    if (drew_) ++drawn_frames_;
    if (drew_ && picture_.stats()) note_bakes(picture_.stats()->status);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, width, height);
    glClearColor(0.08f, 0.08f, 0.085f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    if (panels_alone) return draw_note("The first picture is being prepared", rect);
    picture_.blit(x, height - y - h);
    if (drawn_frames_ > 1) swatches_.update(session_.drawn_sources());
  }

  /// Says so each time that there are more of them.
  void say_missing_glyphs() {
    const std::set<char16_t>& missing = host_.missing_glyphs();
    if (missing.size() <= said_missing_) return;
    said_missing_ = missing.size();
    char text[160];
    std::snprintf(text, sizeof text,
                  "%zu characters of names are shown as ?, the first is U+%04X: install a font that has them, such as "
                  "Debian's fonts-noto-cjk",
                  missing.size(), static_cast<unsigned>(*missing.begin()));
    session_.add_message(MessageLevel::note, text);
  }

  /// What bakes say of themselves, as long as they do.
  void note_bakes(const FrameStatus& status) {
    std::string notes;
    for (const auto& [name, bake] : status.own_bakes)
      for (const std::string& note : bake.notes) notes += (notes.empty() ? "" : "; ") + name + ": " + note;
    session_.set_advice({MessageLevel::warning, notes, true, "bakes"});
  }

  void collect_facts() {
    session_.fill_facts(&facts_);
    const std::optional<BackgroundWork> file = compare_.picture_in_work();
    facts_.picture_in_work = file ? file->what : "";
    if (file) facts_.background.push_back(*file);
    facts_.seconds_left = bake_clock_.update(glfwGetTime(), facts_.background);
    facts_.stats = picture_.stats() ? &*picture_.stats() : nullptr;
    facts_.frame_history_ms = picture_.history_ms();
    facts_.pass_history_ms = picture_.pass_history_ms();
    facts_.smooth_passes = picture_.smooth_passes();
    facts_.picture_px = picture_.drawn_size();
    facts_.converged = picture_.converged();
    meter_.fill_facts(session_, &facts_.meter);
    inspection_.fill_facts(session_, &facts_.inspection);
    stored_light_.fill_facts(&facts_.stored_light);
    facts_.swatches = &swatches_.textures();
    facts_.look_pictures = thumbnails_.textures(session_.state);
    facts_.recent_files = memory_.recent;
  }

  Renderer::Pick pick(float x, float y) {
    const Rect& rect = editor_.layout.picture;
    return picture_.pick(&session_, (x - rect.x) / rect.width, (y - rect.y) / rect.height);
  }

  void handle_pointer(const std::vector<PointerEvent>& events) {
    const bool blocked = ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
    for (const PointerEvent& event : events)
      if (blocked || !compare_.takes(event, session_.state, editor_.layout.picture))
        input_.handle(event, editor_.layout.picture, blocked, &session_,
                      [this](float x, float y) { return pick(x, y); });
  }

  /// Tab goes on from a text field as from any control.
  void leave_field(const std::vector<KeyEvent>& keys) {
    for (const KeyEvent& event : keys)
      if (event.key == GLFW_KEY_TAB && !event.released) session_.state.keyboard_step = event.shift ? -1 : 1;
  }

  void handle_keys(const std::vector<KeyEvent>& keys, EditorActions* actions) {
    for (const KeyEvent& event : keys) {
      if (event.released || is_modifier(event.key)) continue;
      if (input_.dragging() && !event.ctrl) continue;  // the letters fly then
      if (editor_.navigating && event.key == GLFW_KEY_TAB) session_.state.keyboard_step = event.shift ? -1 : 1;
      if (editor_.navigating && !event.ctrl && moves_among_controls(event.key)) continue;
      const Command command = command_of(written_key(event));
      if (command == Command::camera) actions->go_to_camera = event.key - GLFW_KEY_1;
      if (command == Command::panel) open_panel(&session_.state, event.key - GLFW_KEY_1);
      request(command, actions);
      change_view(command);
    }
  }

  /// Commands that the panels have as buttons too.
  void request(Command command, EditorActions* actions) {
    EditorState& state = session_.state;
    if (command == Command::undo) actions->undo = true;
    if (command == Command::redo) actions->redo = true;
    if (command == Command::save) actions->save = true;
    if (command == Command::frame_scene) actions->frame_scene = true;
    if (command == Command::keep_look) actions->keep_look = true;
    if (command == Command::add_key) actions->add_key = true;
    if (command == Command::play) actions->play_path = true;
    if (command == Command::next_look) actions->next_look = 1;
    if (command == Command::previous_look) actions->next_look = -1;
    if (command == Command::compare) compare_.toggle(&session_);
    if (command == Command::swap) compare_.swap(&session_);
    if (command == Command::compare_otherwise && state.compare.on)
      state.compare.how = static_cast<CompareView::How>((static_cast<int>(state.compare.how) + 1) % 3);
    if (command == Command::render_file) compare_.render_file(&session_, picture_);
    if (command == Command::close) glfwSetWindowShouldClose(window_, GLFW_TRUE);
    if (command == Command::open) state.open_path_popup = true;
    if (command == Command::start_screen) state.start_popup = true;
    if (command == Command::menu) {
      state.menu_popup = true;
      state.keyboard_goes_to = "toolbar";
    }
    if (command == Command::next_part) state.keyboard_goes_to = next_part();
  }

  /// Of those that are shown, behind the one that has the keyboard.
  std::string next_part() const {
    static const std::string kOrder[] = {"picture", "left", "right", "toolbar"};
    constexpr std::size_t kCount = std::size(kOrder);
    const auto* at = std::find(std::begin(kOrder), std::end(kOrder), editor_.keyboard_part);
    for (std::size_t i = 1; i <= kCount; ++i) {
      const std::string& next = kOrder[(static_cast<std::size_t>(at - std::begin(kOrder)) + i) % kCount];
      if (next == "picture" || editor_.windows.contains(next)) return next;
    }
    return "picture";
  }

  void isolate_chosen() {
    EditorState& state = session_.state;
    if (!state.edits.hidden_nodes.empty())
      state.edits.hidden_nodes.clear();
    else if (facts_.scene && state.selected_node >= 0)
      isolate(&state, facts_, state.selected_node);
  }

  /// Commands that change how the window shows things.
  void change_view(Command command) {
    EditorState& state = session_.state;
    const auto toggle = [&](Tool tool) { state.tool = state.tool == tool ? Tool::camera : tool; };
    if (command == Command::dent) toggle(Tool::dent);
    if (command == Command::measure_distance) {
      toggle(Tool::distance);
      state.measured.clear();
    }
    if (command == Command::isolate) isolate_chosen();
    if (command == Command::darker) step_exposure(-0.25f);
    if (command == Command::brighter) step_exposure(0.25f);
    if (command == Command::sides) state.left_open = state.right_open = !(state.left_open || state.right_open);
    if (command == Command::help) open_panel(&state, 2);
    if (command == Command::leave) state.tool = Tool::camera;
    if (command == Command::present || (command == Command::leave && state.presenting)) {
      state.presenting = !state.presenting;
      glfw_->set_full_screen(state.presenting);
    }
    if (command == Command::full_screen) glfw_->set_full_screen(!glfw_->is_full_screen());
    if (command == Command::screenshot) shot_wanted_ = true;
    constexpr float kStep = 1.1f;
    if (command == Command::larger) state.text_scale = std::min(kStep * state.text_scale, 3.0f);
    if (command == Command::smaller) state.text_scale = std::max(state.text_scale / kStep, 0.6f);
    if (command == Command::usual_size) state.text_scale = 1.0f;
  }

  void step_exposure(float stops) {
    session_.state.exposure_ev += stops;
    session_.state.auto_exposure = false;
  }

  void fly(float seconds) {
    if (editor_.typing) return;
    const auto held = [&](int key) { return glfwGetKey(window_, key) == GLFW_PRESS ? 1.0f : 0.0f; };
    const glm::vec3 direction(held(GLFW_KEY_D) - held(GLFW_KEY_A), held(GLFW_KEY_E) - held(GLFW_KEY_Q),
                              held(GLFW_KEY_W) - held(GLFW_KEY_S));
    input_.fly(direction, held(GLFW_KEY_LEFT_SHIFT) > 0.0f, seconds, &session_);
  }

  int material_under_mouse() {
    if (editor_.hovered_material >= 0) return editor_.hovered_material;
    double x = 0.0, y = 0.0;
    glfwGetCursorPos(window_, &x, &y);
    const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
    if (!editor_.layout.picture.contains(fx, fy)) return session_.state.selected_material;
    const Renderer::Pick hit = pick(fx, fy);
    return hit.hit ? hit.material : session_.state.selected_material;
  }

  /// A material of the library, on what is under the mouse.
  void drop(const std::string& source) {
    const int material = material_under_mouse();
    if (material < 0 || material >= static_cast<int>(session_.scene().materials.size())) return;
    session_.state.selected_material = material;
    assign_source(&session_.state, session_.scene().materials[static_cast<std::size_t>(material)], source);
  }

  void carry_out(const EditorActions& actions) {
    if (!actions.open_path.empty()) session_.open(actions.open_path, session_.state.selected_material);
    if (actions.go_to_camera >= 0) session_.go_to_camera(actions.go_to_camera);
    if (actions.frame_scene)
      session_.frame_scene(editor_.layout.picture.width / std::max(editor_.layout.picture.height, 1.0f));
    if (actions.save_picture) compare_.save_picture(&session_);
    if (actions.cancel_picture) compare_.cancel_picture(&session_);
    if (actions.meter_exposure) session_.request_metering();
    if (actions.measure_curve) meter_.measure_curve();
    if (actions.compare_reflectors) meter_.compare_reflectors();
    if (actions.apply_budget) meter_.apply_budget(&session_);
    inspection_.carry_out(actions.inspection, &session_);
    stored_light_.carry_out(actions.inspection, &session_);
    if (actions.undo) session_.undo();
    if (actions.redo) session_.redo();
    if (!actions.save_path.empty()) session_.save(actions.save_path);
    if (actions.save && !session_.review().file().empty()) session_.save(session_.review().file());
    if (actions.save && session_.review().file().empty()) session_.state.save_path_popup = true;
    session_.dismiss_message(actions.dismiss_message);
    if (actions.dismiss_messages) session_.dismiss_messages();
  }

  /// What is open goes to the top of the recent files.
  void note_file() {
    const std::string& review = session_.review().file();
    const std::string& open = review.empty() ? session_.scene().name : review;
    if (open == noted_) return;
    noted_ = open;
    if (!options_.screenshot.empty()) return;
    memory_.note(absolute_source(open, std::filesystem::current_path().string()));
    save_window_memory(memory_);
  }

  void remember() {
    if (!options_.screenshot.empty()) return;
    const EditorState& state = session_.state;
    memory_.left_open = state.left_open;
    memory_.right_open = state.right_open;
    memory_.text_scale = state.text_scale;
    if (!glfw_->is_full_screen()) glfwGetWindowSize(window_, &memory_.width, &memory_.height);
    save_window_memory(memory_);
  }

  /// Of the whole window, beside the review.
  void take_screenshot() {
    shot_wanted_ = false;
    namespace fs = std::filesystem;
    const std::string& review = session_.review().file();
    const fs::path folder = review.empty() ? fs::current_path() : fs::path(review).parent_path();
    fs::path file = folder / "maquette.png";
    for (int number = 2; fs::exists(file); ++number) file = folder / ("maquette " + std::to_string(number) + ".png");
    try {
      save_screenshot(file.string());
      session_.add_message(MessageLevel::warning, "written: " + file.string());
    } catch (const Error& error) {
      session_.add_message(MessageLevel::error, error.what());
    }
  }

  void save_screenshot(const std::string& file) const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    const auto w = static_cast<std::size_t>(width);
    std::vector<std::uint8_t> bytes(w * static_cast<std::size_t>(height) * 3);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
    Image image(width, height, 3);
    for (int y = 0; y < height; ++y)
      for (std::size_t i = 0; i < 3 * w; ++i)
        image.data[static_cast<std::size_t>(y) * 3 * w + i] =
            static_cast<float>(bytes[static_cast<std::size_t>(height - 1 - y) * 3 * w + i]) / 255.0f;
    save_png(file, image);
  }

  SceneOptions options_;
  WindowMemory memory_;
  GlfwWindow* glfw_;
  GLFWwindow* window_;
  Inbox* inbox_;
  ImGuiHost host_;
  Glyphs glyphs_;
  std::size_t said_missing_ = 0;
  WindowSession session_;
  WindowPicture picture_;
  WindowMeter meter_;
  WindowInspection inspection_;
  WindowStoredLight stored_light_;
  BakeClock bake_clock_;
  WindowPaths paths_;
  WindowCompare compare_;
  PictureInput input_;
  Swatches swatches_;
  WindowThumbnails thumbnails_;
  EditorFacts facts_;
  EditorFrame editor_;
  double last_frame_s_ = 0.0;
  const std::string state_file_ = window_state_file();
  int drawn_frames_ = 0, shown_frames_ = 0;
  bool shown_ = false, drew_ = false, shot_wanted_ = false;
  std::string noted_;  ///< the file that was open in the last frame
};

}  // namespace

int run_window(const SceneOptions& options) {
  Inbox inbox;
  WindowMemory memory;
  if (options.screenshot.empty()) memory = load_window_memory();
  const bool asked = options.given.contains("--size"), remembered = !asked && memory.width > 0;
  GlfwWindow window(remembered ? memory.width : options.width, remembered ? memory.height : options.height,
                    asked || remembered, &inbox);
  query_device();
  install_debug_output();
  App app(options, memory, &window, &inbox);
  return app.run();
}

}  // namespace maquette

#include "viewer/window_events.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <map>

namespace maquette {

namespace {

bool turns_button(const PointerEvent& event) {
  return event.kind == PointerEvent::Kind::press || event.kind == PointerEvent::Kind::release;
}

bool writes(const KeyEvent& event) { return event.text != 0 && !event.ctrl; }

}  // namespace

bool is_modifier(int key) { return key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER; }

bool moves_among_controls(int key) {
  static constexpr int kKeys[] = {GLFW_KEY_SPACE, GLFW_KEY_ENTER, GLFW_KEY_KP_ENTER, GLFW_KEY_TAB,
                                  GLFW_KEY_LEFT,  GLFW_KEY_RIGHT, GLFW_KEY_UP,       GLFW_KEY_DOWN,
                                  GLFW_KEY_HOME,  GLFW_KEY_END,   GLFW_KEY_ESCAPE};
  return std::ranges::find(kKeys, key) != std::end(kKeys);
}

std::string written_key(const KeyEvent& event) {
  static const std::map<int, std::string> kNames = {{GLFW_KEY_PAGE_UP, "Page Up"}, {GLFW_KEY_PAGE_DOWN, "Page Down"},
                                                    {GLFW_KEY_SPACE, "Space"},     {GLFW_KEY_TAB, "Tab"},
                                                    {GLFW_KEY_ESCAPE, "Escape"},   {GLFW_KEY_KP_ADD, "+"},
                                                    {GLFW_KEY_KP_SUBTRACT, "-"},   {GLFW_KEY_KP_0, "0"}};
  std::string name;
  if (const auto known = kNames.find(event.key); known != kNames.end())
    name = known->second;
  else if (event.key >= GLFW_KEY_F1 && event.key <= GLFW_KEY_F12)
    name = "F" + std::to_string(event.key - GLFW_KEY_F1 + 1);
  else if (event.key > ' ' && event.key < 127)
    name = static_cast<char>(event.key);
  const bool letter = event.key >= GLFW_KEY_A && event.key <= GLFW_KEY_Z;
  return std::string(event.ctrl ? "Ctrl+" : "") + (event.ctrl && event.shift && letter ? "Shift+" : "") + name;
}

void Inbox::add(const PointerEvent& event) { events_.emplace_back(event); }

void Inbox::add(const KeyEvent& event) {
  const auto same = [&](const Event& waiting) {
    const auto* key = std::get_if<KeyEvent>(&waiting);
    return key && key->key == event.key && key->ctrl == event.ctrl && key->shift == event.shift;
  };
  if (event.repeated && std::any_of(events_.begin(), events_.end(), same)) return;
  events_.emplace_back(event);
}

void Inbox::add_text(unsigned letter) {
  auto* last = events_.empty() ? nullptr : std::get_if<KeyEvent>(&events_.back());
  if (last && last->text == 0 && !last->released && !is_modifier(last->key)) {
    last->text = letter;
    return;
  }
  KeyEvent event;
  event.text = letter;
  events_.emplace_back(event);
}

Inbox::Take Inbox::take(const PointerEvent& event, const InputBatch& batch) const {
  if (!turns_button(event)) return Take::yes;
  if (!batch.keys.empty()) return Take::no;
  // A press comes one frame after the move to its position, because tabs must have been hovered before.
  if (event.kind == PointerEvent::Kind::press && !batch.pointer.empty()) return Take::no;
  return Take::yes_and_end;
}

Inbox::Take Inbox::take(const KeyEvent& event, const InputBatch& batch, bool wait) const {
  if (is_modifier(event.key)) return Take::yes;
  if (wait) return Take::no;
  if (batch.typing && writes(event)) return Take::yes;
  const bool wrote = std::any_of(batch.keys.begin(), batch.keys.end(), writes);
  if (wrote || (key_was_down_ && !writes(event))) return Take::no;
  return Take::yes_and_end;
}

InputBatch Inbox::next(bool typing, bool wait) {
  InputBatch batch;
  batch.typing = typing;
  Take last = Take::yes;
  while (last == Take::yes && !events_.empty()) {
    const Event& event = events_.front();
    const auto* pointer = std::get_if<PointerEvent>(&event);
    const auto* key = std::get_if<KeyEvent>(&event);
    last = pointer ? take(*pointer, batch) : take(*key, batch, wait);
    if (last == Take::no) break;
    if (pointer)
      batch.pointer.push_back(*pointer);
    else
      batch.keys.push_back(*key);
    events_.pop_front();
  }
  key_was_down_ = std::any_of(batch.keys.begin(), batch.keys.end(),
                              [](const KeyEvent& key) { return !writes(key) && !is_modifier(key.key); });
  return batch;
}

}  // namespace maquette

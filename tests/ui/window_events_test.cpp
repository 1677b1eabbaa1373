// What the frames of a window get of events that came between them.
#include "viewer/window_events.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace maquette {
namespace {

using Kind = PointerEvent::Kind;

KeyEvent pressed(int key, unsigned text = 0, bool ctrl = false) {
  KeyEvent event;
  event.key = key;
  event.text = text;
  event.ctrl = ctrl;
  return event;
}

/// `m p r w` are events of the mouse, letters in capitals keys that write, `!` Return.
void add(Inbox* inbox, const std::string& events) {
  for (const char c : events) {
    if (c == 'm') inbox->add(PointerEvent{.kind = Kind::move});
    if (c == 'p') inbox->add(PointerEvent{.kind = Kind::press});
    if (c == 'r') inbox->add(PointerEvent{.kind = Kind::release});
    if (c == 'w') inbox->add(PointerEvent{.kind = Kind::wheel});
    if (c == '!') inbox->add(pressed(GLFW_KEY_ENTER));
    if (c >= 'A' && c <= 'Z') {
      inbox->add(pressed(c));
      inbox->add_text(static_cast<unsigned>(c) + 32u);
    }
  }
}

std::string text_of(const InputBatch& batch) {
  std::string text;
  for (const PointerEvent& event : batch.pointer) text += "prmw"[static_cast<int>(event.kind)];
  for (const KeyEvent& event : batch.keys) text += event.key == GLFW_KEY_ENTER ? '!' : static_cast<char>(event.key);
  return text;
}

std::string batches(Inbox* inbox, bool typing) {
  std::string text;
  while (!inbox->empty()) text += text_of(inbox->next(typing, false)) + " ";
  return text;
}

TEST(Inbox, GivesOneTurnOfAButtonAFrame) {
  Inbox inbox;
  add(&inbox, "mprmwpm");
  EXPECT_EQ(batches(&inbox, false), "m p r mw p m ");
}

TEST(Inbox, KeysKeepTheirPlaceAmongClicks) {
  Inbox inbox;
  add(&inbox, "mprLmprK");
  EXPECT_EQ(batches(&inbox, false), "m p r L m p r K ");
}

TEST(Inbox, AKeyThatOpensAFieldEndsTheFrameAndTheRestWaits) {
  Inbox inbox;
  add(&inbox, "OAB!P");
  EXPECT_EQ(text_of(inbox.next(false, false)), "O");
  EXPECT_EQ(text_of(inbox.next(false, true)), "");
  EXPECT_EQ(text_of(inbox.next(false, true)), "");
  const InputBatch letters = inbox.next(true, false);
  EXPECT_EQ(text_of(letters), "AB");
  EXPECT_EQ(letters.keys[0].text, 'a');
  EXPECT_EQ(text_of(inbox.next(true, false)), "!");
  EXPECT_EQ(text_of(inbox.next(false, false)), "P") << "the field is left: a shortcut";
  EXPECT_TRUE(inbox.empty());
}

TEST(Inbox, TheSameKeyTwiceIsUpInBetween) {
  Inbox inbox;
  add(&inbox, "!!");
  EXPECT_EQ(text_of(inbox.next(true, false)), "!");
  EXPECT_EQ(text_of(inbox.next(true, false)), "");
  EXPECT_EQ(text_of(inbox.next(true, false)), "!");
}

TEST(Inbox, AHeldKeyIsWaitingOnce) {
  Inbox inbox;
  KeyEvent event = pressed(GLFW_KEY_RIGHT_BRACKET);
  inbox.add(event);
  event.repeated = true;
  for (int i = 0; i < 20; ++i) inbox.add(event);
  inbox.next(false, false);
  EXPECT_TRUE(inbox.empty());
}

TEST(Inbox, NothingIsLostNorChangesItsOrder) {
  std::mt19937 random(36);
  for (int round = 0; round < 500; ++round) {
    Inbox inbox;
    std::string events, handed_out;
    for (int i = 0; i < 40; ++i) events += "mprwABCDE!"[random() % 10];
    std::size_t added = 0;
    int waits = 0;
    while (added < events.size() || !inbox.empty()) {
      const std::size_t more = std::min<std::size_t>(random() % 6, events.size() - added);
      add(&inbox, events.substr(added, more));
      added += more;
      const bool wait = random() % 4 == 0 && waits++ < 20;
      handed_out += text_of(inbox.next(random() % 2 == 0, wait));
    }
    // Within a frame the mouse is handled first: order is kept in each kind, and of keys against turns of a button.
    const auto only = [](std::string text, const std::string& kinds) {
      std::erase_if(text, [&](char c) { return kinds.find(c) == std::string::npos; });
      return text;
    };
    EXPECT_EQ(only(handed_out, "mprw"), only(events, "mprw"));
    EXPECT_EQ(only(handed_out, "prABCDE!"), only(events, "prABCDE!"));
  }
}

}  // namespace
}  // namespace maquette

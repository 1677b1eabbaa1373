#include "ui/undo.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

TEST(Undo, ADragIsOneStep) {
  UndoStack stack;
  Edits edits;
  stack.observe(edits, false);
  for (int i = 1; i <= 10; ++i) {
    edits.env_rotation_deg = static_cast<float>(i);
    stack.observe(edits, true);
  }
  stack.observe(edits, false);
  ASSERT_TRUE(stack.can_undo());
  EXPECT_EQ(stack.undo()->env_rotation_deg, 0.0f);
  EXPECT_FALSE(stack.can_undo());
  EXPECT_FALSE(stack.undo().has_value());
}

TEST(Undo, StepsComeBackInReverse) {
  UndoStack stack;
  Edits edits;
  stack.observe(edits, false);
  edits.materials["paint"] = "builtin:a";
  stack.observe(edits, false);
  edits.materials["paint"] = "builtin:b";
  stack.observe(edits, false);
  edits = *stack.undo();
  EXPECT_EQ(edits.materials.at("paint"), "builtin:a");
  stack.observe(edits, false);  // what undo gave is no new step
  edits = *stack.undo();
  EXPECT_TRUE(edits.materials.empty());
  EXPECT_FALSE(stack.can_undo());
}

TEST(Undo, AChangeThatFailedLeavesNoStep) {
  UndoStack stack;
  Edits edits;
  stack.observe(edits, false);
  const Edits good = edits;
  edits.environment = "missing.hdr";
  stack.observe(edits, false);
  stack.correct(good);
  stack.observe(good, false);
  EXPECT_FALSE(stack.can_undo());
}

TEST(Undo, DepthIsBounded) {
  UndoStack stack;
  Edits edits;
  for (std::size_t i = 0; i < UndoStack::kDepth + 50; ++i) {
    edits.env_scale = 1.0f + static_cast<float>(i);
    stack.observe(edits, false);
  }
  std::size_t steps = 0;
  while (stack.undo()) ++steps;
  EXPECT_EQ(steps, UndoStack::kDepth);
}

}  // namespace
}  // namespace maquette

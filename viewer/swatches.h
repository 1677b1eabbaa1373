#pragma once

#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "render/bake/background_worker.h"
#include "render/gl/objects.h"
#include "scenes/brdf.h"

namespace maquette {

/// Ball of a BRDF under a small studio, `side` x `side` RGBA bytes, row 0 on top, transparent around the ball.
std::vector<std::uint8_t> draw_brdf_ball(const BrdfTable& table, int side);

/// Balls of the built-in library for the materials list, drawn one by one in the background.
class Swatches {
 public:
  static constexpr int kSide = 48;
  /// Starts the work at the first call; takes over what is ready. Needs a current context.
  void update();
  /// Source (`builtin:NAME`) -> texture.
  const std::map<std::string, unsigned>& textures() const { return textures_; }

 private:
  struct Ball {
    std::string source;
    std::vector<std::uint8_t> rgba;
  };
  using Worker = BackgroundWorker<std::monostate, std::vector<Ball>>;
  std::map<std::string, unsigned> textures_;
  std::vector<Texture> owners_;  ///< as many as balls were taken over
  std::unique_ptr<Worker> worker_;
};

}  // namespace maquette

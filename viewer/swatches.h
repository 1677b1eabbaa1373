#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "render/bake/background_worker.h"
#include "render/gl/objects.h"
#include "scenes/brdf.h"

namespace maquette {

/// Ball of a BRDF under a small studio, `side` x `side` RGBA bytes, row 0 on top, transparent around the ball.
std::vector<std::uint8_t> draw_brdf_ball(const BrdfTable& table, int side);

/// Balls for the materials list, drawn one by one in the background: of the built-in library, and of other tables that
/// the scene is drawn with.
class Swatches {
 public:
  static constexpr int kSide = 48;
  /// Starts the work at the first call; takes over what is ready. Needs a current context. `drawn`: sources of tables
  /// that are loaded, or BTFs that are made.
  void update(const std::vector<std::string>& drawn);
  /// Source (`builtin:NAME`, a file, a folder) -> texture.
  const std::map<std::string, unsigned>& textures() const { return textures_; }

 private:
  struct Ball {
    std::string source;
    std::vector<std::uint8_t> rgba;
  };
  using Library = BackgroundWorker<std::monostate, std::vector<Ball>>;
  using Others = BackgroundWorker<std::string, Ball>;
  void add(const Ball& ball);
  void update_library();

  std::map<std::string, unsigned> textures_;
  std::vector<Texture> owners_;
  std::size_t of_library_ = 0;  ///< balls of it that were taken over
  std::set<std::string> tried_;
  bool busy_ = false;  ///< with another table
  std::unique_ptr<Library> library_;
  std::unique_ptr<Others> others_;
};

}  // namespace maquette

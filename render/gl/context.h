#pragma once

#include <memory>
#include <string>
#include <vector>

namespace maquette {

/// What the driver says of itself; every field is filled once a context is current.
struct DeviceInfo {
  std::string vendor, renderer, version, shading_language;
  int major = 0, minor = 0;
  int max_storage_block_bytes = 0;
  int max_uniform_block_bytes = 0;
  int max_texture_buffer_texels = 0;
  int max_texture_size = 0;
  int max_layers = 0;
  int max_samples = 0;
  int max_compute_shared_bytes = 0;
  bool software = false;  ///< llvmpipe or softpipe
};

/// An OpenGL 4.5 core context without a window (EGL: the device platform where there is a GPU driver, else
/// surfaceless). Move-only; current on the thread that made it until destroyed.
class GlContext {
 public:
  /// Throws Error that names what was found when there is no EGL, no device or less than OpenGL 4.5.
  static GlContext create_headless();
  GlContext(GlContext&&) noexcept;
  GlContext& operator=(GlContext&&) noexcept;
  ~GlContext();

 private:
  struct Impl;
  explicit GlContext(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Of the current context. Throws Error when it is below OpenGL 4.5.
DeviceInfo query_device();

/// Routes GL debug messages of errors to a counter (tests fail on any) and to the log. Call once a context is current.
void install_debug_output();
/// GL errors since the last call.
std::vector<std::string> take_gl_errors();

}  // namespace maquette

#include "render/gl/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <cstdlib>
#include <cstring>
#include <mutex>
#include <optional>

#include "scenes/error.h"

namespace maquette {

struct GlContext::Impl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  ~Impl() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglTerminate(display);
  }
};

GlContext::GlContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GlContext::GlContext(GlContext&&) noexcept = default;
GlContext& GlContext::operator=(GlContext&&) noexcept = default;
GlContext::~GlContext() = default;

namespace {

bool has_extension(const char* list, const char* name) { return list && std::strstr(list, name); }

/// Displays to try in order: each GPU device, then Mesa's surfaceless platform, then the default display.
std::vector<EGLDisplay> candidate_displays() {
  std::vector<EGLDisplay> displays;
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (has_extension(client, "EGL_EXT_device_enumeration") && has_extension(client, "EGL_EXT_platform_device")) {
    EGLDeviceEXT devices[8];
    EGLint count = 0;
    if (eglQueryDevicesEXT(8, devices, &count)) {
      for (EGLint i = 0; i < count; ++i) {
        const char* extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
        if (has_extension(extensions, "EGL_MESA_device_software")) continue;  // surfaceless reaches it as well
        displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
      }
    }
  }
  if (has_extension(client, "EGL_MESA_platform_surfaceless"))
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr));
  return displays;
}

EGLContext create_context(EGLDisplay display) {
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) return EGL_NO_CONTEXT;
  if (!eglBindAPI(EGL_OPENGL_API)) return EGL_NO_CONTEXT;
  const EGLint config_attributes[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  eglChooseConfig(display, config_attributes, &config, 1, &count);
  const EGLint context_attributes[] = {
      EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  const EGLContext context =
      eglCreateContext(display, count > 0 ? config : EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, context_attributes);
  if (context == EGL_NO_CONTEXT) return EGL_NO_CONTEXT;
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    eglDestroyContext(display, context);
    return EGL_NO_CONTEXT;
  }
  return context;
}

/// What a display offers when 4.5 cannot be had, for the error message.
std::string describe_best_version(EGLDisplay display) {
  if (display == EGL_NO_DISPLAY || !eglBindAPI(EGL_OPENGL_API)) return {};
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, nullptr);
  if (context == EGL_NO_CONTEXT) return {};
  std::string text;
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    text = std::string(reinterpret_cast<const char*>(glGetString(GL_RENDERER))) + " with OpenGL " +
           reinterpret_cast<const char*>(glGetString(GL_VERSION));
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(display, context);
  return text;
}

}  // namespace

GlContext GlContext::create_headless() {
  if (!epoxy_has_egl()) throw Error("graphics", "there is no EGL library", "install libegl1 and libgl1-mesa-dri");
  std::string found;
  for (EGLDisplay display : candidate_displays()) {
    auto impl = std::make_unique<Impl>();
    impl->display = display;
    impl->context = create_context(display);
    if (impl->context != EGL_NO_CONTEXT) {
      query_device();
      install_debug_output();
      return GlContext(std::move(impl));
    }
    const std::string best = describe_best_version(display);
    if (!best.empty()) found = best;
  }
  throw Error("graphics", "OpenGL 4.5 core is needed, found " + (found.empty() ? "no usable EGL device" : found),
              "install a newer driver, or Mesa's llvmpipe (libgl1-mesa-dri); `maquette doctor` says more");
}

DeviceInfo query_device() {
  const auto text = [](GLenum name) {
    const GLubyte* value = glGetString(name);
    return value ? std::string(reinterpret_cast<const char*>(value)) : std::string("unknown");
  };
  const auto integer = [](GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
  };
  DeviceInfo info;
  info.vendor = text(GL_VENDOR);
  info.renderer = text(GL_RENDERER);
  info.version = text(GL_VERSION);
  info.shading_language = text(GL_SHADING_LANGUAGE_VERSION);
  info.major = integer(GL_MAJOR_VERSION);
  info.minor = integer(GL_MINOR_VERSION);
  if (info.major * 10 + info.minor < 45)
    throw Error("graphics", "OpenGL 4.5 core is needed, found " + info.renderer + " with " + info.version,
                "install a newer driver or Mesa's llvmpipe");
  info.max_storage_block_bytes = integer(GL_MAX_SHADER_STORAGE_BLOCK_SIZE);
  info.max_uniform_block_bytes = integer(GL_MAX_UNIFORM_BLOCK_SIZE);
  info.max_texture_buffer_texels = integer(GL_MAX_TEXTURE_BUFFER_SIZE);
  info.max_texture_size = integer(GL_MAX_TEXTURE_SIZE);
  info.max_layers = integer(GL_MAX_ARRAY_TEXTURE_LAYERS);
  info.max_samples = integer(GL_MAX_SAMPLES);
  info.max_compute_shared_bytes = integer(GL_MAX_COMPUTE_SHARED_MEMORY_SIZE);
  info.software =
      info.renderer.find("llvmpipe") != std::string::npos || info.renderer.find("softpipe") != std::string::npos;
  return info;
}

namespace {

struct DebugLog {
  std::mutex mutex;
  std::vector<std::string> errors;
};

/// One per process: GL gives the callback a pointer, and contexts come and go in tests.
DebugLog& debug_log() {
  static DebugLog log;
  return log;
}

void GLAPIENTRY on_debug_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* message,
                                 const void*) {
  if (type != GL_DEBUG_TYPE_ERROR && severity != GL_DEBUG_SEVERITY_HIGH) return;
  DebugLog& log = debug_log();
  const std::lock_guard lock(log.mutex);
  log.errors.emplace_back(message, static_cast<std::size_t>(length));
}

}  // namespace

void install_debug_output() {
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(on_debug_message, nullptr);
}

std::vector<std::string> take_gl_errors() {
  std::vector<std::string> errors;
  for (GLenum code = glGetError(); code != GL_NO_ERROR; code = glGetError())
    errors.push_back("glGetError " + std::to_string(code));
  DebugLog& log = debug_log();
  const std::lock_guard lock(log.mutex);
  errors.insert(errors.end(), log.errors.begin(), log.errors.end());
  log.errors.clear();
  return errors;
}

}  // namespace maquette

#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace maquette {

/// Owner of one GL name; move-only. `Traits::destroy` deletes it.
template <typename Traits>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    if (this != &other) {
      reset();
      name_ = std::exchange(other.name_, 0);
    }
    return *this;
  }
  ~GlName() { reset(); }
  void reset() {
    if (name_) Traits::destroy(name_);
    name_ = 0;
  }
  GLuint get() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

struct BufferTraits {
  static void destroy(GLuint name) { glDeleteBuffers(1, &name); }
};
struct TextureTraits {
  static void destroy(GLuint name) { glDeleteTextures(1, &name); }
};
struct FramebufferTraits {
  static void destroy(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct VertexArrayTraits {
  static void destroy(GLuint name) { glDeleteVertexArrays(1, &name); }
};
struct ProgramTraits {
  static void destroy(GLuint name) { glDeleteProgram(name); }
};

/// Immutable-size buffer that knows its bytes.
class Buffer {
 public:
  Buffer() = default;
  /// `data` may be null. `flags` as glNamedBufferStorage.
  Buffer(const std::string& label, std::size_t bytes, const void* data = nullptr,
         GLbitfield flags = GL_DYNAMIC_STORAGE_BIT);
  template <typename T>
  static Buffer from(const std::string& label, const std::vector<T>& values) {
    return Buffer(label, values.size() * sizeof(T), values.data());
  }
  void update(std::size_t offset, std::size_t bytes, const void* data);
  void clear_to_zero();
  void read(std::size_t offset, std::size_t bytes, void* data) const;
  GLuint get() const { return name_.get(); }
  std::size_t bytes() const { return bytes_; }
  explicit operator bool() const { return static_cast<bool>(name_); }

 private:
  GlName<BufferTraits> name_;
  std::size_t bytes_ = 0;
};

/// 2D, 2D array or buffer texture that knows its bytes.
class Texture {
 public:
  Texture() = default;
  static Texture make_2d(const std::string& label, GLenum internal_format, int width, int height, int levels = 1);
  static Texture make_2d_array(const std::string& label, GLenum internal_format, int width, int height, int layers,
                               int levels = 1);
  /// Throws Error for more texels than the driver can address.
  static Texture make_buffer(const std::string& label, GLenum internal_format, const Buffer& buffer);
  void set_filter(GLenum min_filter, GLenum mag_filter);
  void set_wrap(GLenum wrap_s, GLenum wrap_t);
  void upload(int level, int width, int height, GLenum format, GLenum type, const void* data);
  GLuint get() const { return name_.get(); }
  int width() const { return width_; }
  int height() const { return height_; }
  GLenum format() const { return format_; }
  std::size_t bytes() const { return bytes_; }
  explicit operator bool() const { return static_cast<bool>(name_); }

 private:
  GlName<TextureTraits> name_;
  int width_ = 0, height_ = 0;
  GLenum format_ = 0;
  std::size_t bytes_ = 0;
};

/// Bytes of one texel of a sized internal format that we use; asserts on others.
std::size_t texel_bytes(GLenum internal_format);

using ShaderDefines = std::vector<std::pair<std::string, std::string>>;

/// A linked program. Sources come from shaders/ (disk in development, embedded otherwise) with `#include "path"`
/// resolved.
class Program {
 public:
  Program() = default;
  /// Throws Error with `file:line: message` of the driver's log.
  static Program compute(const std::string& path, const ShaderDefines& defines = {});
  static Program graphics(const std::string& vertex_path, const std::string& fragment_path,
                          const ShaderDefines& defines = {});
  GLuint get() const { return name_.get(); }
  GLint location(const std::string& uniform) const;
  void set(const std::string& uniform, int value) const;
  void set(const std::string& uniform, float value) const;
  explicit operator bool() const { return static_cast<bool>(name_); }

 private:
  GlName<ProgramTraits> name_;
  mutable std::map<std::string, GLint> locations_;
};

/// A shader below shaders/ as a compiler takes it: version and defines, includes expanded. `#line` and messages name
/// files by their index in `files`.
struct ShaderText {
  std::string source;
  std::vector<std::string> files;
  /// A compiler's message with the names of the files: an index before a colon or a bracket, at the begin of a line or
  /// after `prefix`.
  std::string name_files(std::string message, const std::string& prefix = {}) const;
};
/// Text of a shader below shaders/, includes expanded, to be made part of another. Throws Error when absent.
std::string load_shader_text(const std::string& path);
/// Throws Error when a file is absent.
ShaderText shader_text(const std::string& path, const ShaderDefines& defines = {});

}  // namespace maquette

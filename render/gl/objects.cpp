#include "render/gl/objects.h"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string_view>

#include "render/gl/shader_source.h"
#include "scenes/error.h"

namespace maquette {

Buffer::Buffer(const std::string& label, std::size_t bytes, const void* data, GLbitfield flags) : bytes_(bytes) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  name_ = GlName<BufferTraits>(name);
  glNamedBufferStorage(name, static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, 16)), bytes ? data : nullptr, flags);
  glObjectLabel(GL_BUFFER, name, static_cast<GLsizei>(label.size()), label.c_str());
}

void Buffer::update(std::size_t offset, std::size_t bytes, const void* data) {
  assert(offset + bytes <= bytes_);
  if (bytes) glNamedBufferSubData(get(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void Buffer::clear_to_zero() { glClearNamedBufferData(get(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr); }

void Buffer::read(std::size_t offset, std::size_t bytes, void* data) const {
  glGetNamedBufferSubData(get(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

std::size_t texel_bytes(GLenum internal_format) {
  switch (internal_format) {
    case GL_R8:
    case GL_R8UI:
      return 1;
    case GL_R16F:
    case GL_R16UI:
    case GL_RG8:
    case GL_RG8UI:
      return 2;
    case GL_R32F:
    case GL_R32UI:
    case GL_RG16F:
    case GL_RGBA8:
    case GL_RGBA8UI:
    case GL_SRGB8_ALPHA8:
    case GL_RGB9_E5:
    case GL_DEPTH_COMPONENT32F:
    case GL_RG16_SNORM:
    case GL_RGB10_A2:
      return 4;
    case GL_RG32F:
    case GL_RG32UI:
    case GL_RGBA16F:
    case GL_RGBA16:
    case GL_RGBA16UI:
      return 8;
    case GL_RGB32F:
      return 12;
    case GL_RGBA32F:
    case GL_RGBA32UI:
      return 16;
    default:
      assert(false && "texel_bytes: unlisted format");
      return 0;
  }
}

Texture Texture::make_2d(const std::string& label, GLenum internal_format, int width, int height, int levels) {
  Texture texture;
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  texture.name_ = GlName<TextureTraits>(name);
  glTextureStorage2D(name, levels, internal_format, width, height);
  glObjectLabel(GL_TEXTURE, name, static_cast<GLsizei>(label.size()), label.c_str());
  texture.width_ = width;
  texture.height_ = height;
  texture.format_ = internal_format;
  for (int level = 0; level < levels; ++level)
    texture.bytes_ += texel_bytes(internal_format) * static_cast<std::size_t>(std::max(1, width >> level)) *
                      static_cast<std::size_t>(std::max(1, height >> level));
  texture.set_filter(GL_NEAREST_MIPMAP_NEAREST, GL_NEAREST);  // fetches of other levels are undefined without
  texture.set_wrap(GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
  return texture;
}

Texture Texture::make_2d_array(const std::string& label, GLenum internal_format, int width, int height, int layers,
                               int levels) {
  Texture texture;
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  texture.name_ = GlName<TextureTraits>(name);
  glTextureStorage3D(name, levels, internal_format, width, height, layers);
  glObjectLabel(GL_TEXTURE, name, static_cast<GLsizei>(label.size()), label.c_str());
  texture.width_ = width;
  texture.height_ = height;
  texture.format_ = internal_format;
  texture.bytes_ = texel_bytes(internal_format) * static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                   static_cast<std::size_t>(layers);
  texture.set_filter(GL_NEAREST_MIPMAP_NEAREST, GL_NEAREST);  // fetches of other levels are undefined without
  texture.set_wrap(GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
  return texture;
}

Texture Texture::make_buffer(const std::string& label, GLenum internal_format, const Buffer& buffer) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  const std::size_t texels = buffer.bytes() / texel_bytes(internal_format);
  if (texels > static_cast<std::size_t>(most))
    throw Error("scene",
                std::to_string(texels) + " elements of its " + label + " are more than this driver can address (" +
                    std::to_string(most) + ")",
                "use a lighter model");
  Texture texture;
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
  texture.name_ = GlName<TextureTraits>(name);
  glTextureBuffer(name, internal_format, buffer.get());
  glObjectLabel(GL_TEXTURE, name, static_cast<GLsizei>(label.size()), label.c_str());
  texture.format_ = internal_format;
  return texture;
}

void Texture::set_filter(GLenum min_filter, GLenum mag_filter) {
  glTextureParameteri(get(), GL_TEXTURE_MIN_FILTER, static_cast<GLint>(min_filter));
  glTextureParameteri(get(), GL_TEXTURE_MAG_FILTER, static_cast<GLint>(mag_filter));
}

void Texture::set_wrap(GLenum wrap_s, GLenum wrap_t) {
  glTextureParameteri(get(), GL_TEXTURE_WRAP_S, static_cast<GLint>(wrap_s));
  glTextureParameteri(get(), GL_TEXTURE_WRAP_T, static_cast<GLint>(wrap_t));
}

void Texture::upload(int level, int width, int height, GLenum format, GLenum type, const void* data) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(get(), level, 0, 0, width, height, format, type, data);
}

namespace {

/// From disk where the path is absolute (a technique that is not of this program), or below MAQUETTE_SHADERS (hot
/// reload in development) when that is set; else from the program itself.
std::string read_shader(const std::string& path) {
  const char* folder = std::getenv("MAQUETTE_SHADERS");
  if (folder || std::filesystem::path(path).is_absolute()) {
    std::ifstream file(std::filesystem::path(folder ? folder : "") / path);
    std::stringstream text;
    if (file && text << file.rdbuf()) return text.str();
  }
  for (const EmbeddedShader& shader : embedded_shaders())
    if (shader.path == path) return std::string(shader.text);
  throw Error(path, "no such shader in this build");
}

/// The path of a line `#include "PATH"`; empty: the line is no such line.
std::string_view included_path(std::string_view line) {
  constexpr std::string_view kInclude = "#include";
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  if (!line.starts_with(kInclude)) return {};
  const std::size_t begin = line.find('"'), end = line.find('"', begin + 1);
  return end == std::string_view::npos ? std::string_view() : line.substr(begin + 1, end - begin - 1);
}

/// Appends `path` with includes expanded once each; `#line` keeps the driver's messages readable through `files`.
void expand(const std::string& path, std::set<std::string>* seen, std::vector<std::string>* files, std::string* out) {
  if (!seen->insert(path).second) return;
  files->push_back(path);
  const std::size_t file_index = files->size() - 1;
  std::istringstream lines(read_shader(path));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (const std::string_view included = included_path(line); !included.empty()) {
      expand(std::string(included), seen, files, out);
      *out += "#line " + std::to_string(number + 1) + " " + std::to_string(file_index) + "\n";
    } else if (line.rfind("#pragma once", 0) != 0) {
      *out += line + "\n";
    }
    if (number == 1 && line.rfind("#include", 0) != 0) *out += "#line 2 " + std::to_string(file_index) + "\n";
  }
}

GLuint compile(GLenum stage, const std::string& path, const ShaderDefines& defines) {
  const ShaderText expanded = shader_text(path, defines);
  const GLuint shader = glCreateShader(stage);
  const char* text = expanded.source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok) return shader;
  std::string log(8192, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  glDeleteShader(shader);
  // Mesa writes "index:line(column): ..."
  throw Error(path, "the shader does not compile: " + expanded.name_files(log));
}

GLuint link(const std::string& what, std::initializer_list<GLuint> shaders) {
  const GLuint program = glCreateProgram();
  for (GLuint shader : shaders) glAttachShader(program, shader);
  glLinkProgram(program);
  for (GLuint shader : shaders) glDeleteShader(shader);
  GLint ok = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &ok);
  if (ok) return program;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  glDeleteProgram(program);
  throw Error(what, "the shader program does not link: " + log);
}

}  // namespace

std::string ShaderText::name_files(std::string message, const std::string& prefix) const {
  for (std::size_t i = files.size(); i-- > 0;)
    message = std::regex_replace(message, std::regex("(^|\n)" + prefix + std::to_string(i) + "[:(]"),
                                 "$1" + prefix + files[i] + ":");
  return message;
}

std::string load_shader_text(const std::string& path) {
  std::set<std::string> seen;
  std::vector<std::string> files;
  std::string text;
  expand(path, &seen, &files, &text);
  return text;
}

ShaderText shader_text(const std::string& path, const ShaderDefines& defines) {
  ShaderText text;
  text.source = "#version 450 core\n";
  for (const auto& [name, value] : defines) text.source += "#define " + name + " " + value + "\n";
  text.source += "#line 1 0\n";
  std::set<std::string> seen;
  expand(path, &seen, &text.files, &text.source);
  return text;
}

Program Program::compute(const std::string& path, const ShaderDefines& defines) {
  Program program;
  program.name_ = GlName<ProgramTraits>(link(path, {compile(GL_COMPUTE_SHADER, path, defines)}));
  glObjectLabel(GL_PROGRAM, program.get(), static_cast<GLsizei>(path.size()), path.c_str());
  return program;
}

Program Program::graphics(const std::string& vertex_path, const std::string& fragment_path,
                          const ShaderDefines& defines) {
  const GLuint vertex = compile(GL_VERTEX_SHADER, vertex_path, defines);
  Program program;
  program.name_ =
      GlName<ProgramTraits>(link(fragment_path, {vertex, compile(GL_FRAGMENT_SHADER, fragment_path, defines)}));
  glObjectLabel(GL_PROGRAM, program.get(), static_cast<GLsizei>(fragment_path.size()), fragment_path.c_str());
  return program;
}

GLint Program::location(const std::string& uniform) const {
  const auto found = locations_.find(uniform);
  if (found != locations_.end()) return found->second;
  return locations_[uniform] = glGetUniformLocation(get(), uniform.c_str());
}

void Program::set(const std::string& uniform, int value) const { glProgramUniform1i(get(), location(uniform), value); }
void Program::set(const std::string& uniform, float value) const {
  glProgramUniform1f(get(), location(uniform), value);
}

}  // namespace maquette

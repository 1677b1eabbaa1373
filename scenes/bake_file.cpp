#include "scenes/bake_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <memory>
#include <span>

#include "scenes/error.h"
#include "scenes/exr_stream.h"
#include "scenes/files.h"

namespace maquette {

namespace {

constexpr std::size_t kWidth = 4096;
constexpr std::size_t kMaxRows = std::size_t{1} << 17;  // 2^29 entries
constexpr const char* kCountName = "maquette.count";
constexpr const char* kChecksumName = "maquette.checksum";
constexpr const char* kPrefix = "maquette.bake.";

std::size_t length_of(const BakeTable& table) {
  std::size_t length = 0;
  for (const auto& [name, values] : table.integers) length = std::max(length, values.size());
  for (const auto& [name, values] : table.floats) length = std::max(length, values.size());
  return length;
}

std::size_t rows_of(std::size_t count) { return std::max<std::size_t>((count + kWidth - 1) / kWidth, 1); }

std::string checksum(const BakeFile& file) {
  std::uint64_t hash = 0;
  for (const BakeTable& table : file.tables) {
    hash = content_hash(std::as_bytes(std::span(table.name)), hash);
    for (const auto& [name, values] : table.integers) hash = content_hash(std::as_bytes(std::span(values)), hash);
    for (const auto& [name, values] : table.floats) hash = content_hash(std::as_bytes(std::span(values)), hash);
  }
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

Imf::Header make_header(const BakeTable& table) {
  const std::size_t count = length_of(table);
  Imf::Header header(static_cast<int>(kWidth), static_cast<int>(rows_of(count)));
  header.setName(table.name);
  header.setType(Imf::SCANLINEIMAGE);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.insert(kCountName, Imf::StringAttribute(std::to_string(count)));
  for (const auto& [name, values] : table.integers) header.channels().insert(name, Imf::Channel(Imf::UINT));
  for (const auto& [name, values] : table.floats) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  return header;
}

/// Columns of unequal length could not be read back unchanged.
[[maybe_unused]] bool is_even(const BakeTable& table) {
  const std::size_t length = length_of(table);
  return std::all_of(table.integers.begin(), table.integers.end(),
                     [&](auto& c) { return c.second.size() == length; }) &&
         std::all_of(table.floats.begin(), table.floats.end(), [&](auto& c) { return c.second.size() == length; });
}

template <typename T>
void insert_slice(Imf::FrameBuffer* buffer, Imf::PixelType type, const std::string& name, std::vector<T>* values,
                  std::size_t rows) {
  values->resize(rows * kWidth);
  buffer->insert(name, Imf::Slice::Make(type, values->data(), {0, 0}, static_cast<long long>(kWidth),
                                        static_cast<long long>(rows)));
}

void write_parts(const std::string& path, const BakeFile& file) {
  std::vector<Imf::Header> headers;
  for (const BakeTable& table : file.tables) headers.push_back(make_header(table));
  // Parts may differ in their data window, but must have the same display window.
  int tallest = 0;
  for (const Imf::Header& header : headers) tallest = std::max(tallest, header.dataWindow().max.y);
  for (Imf::Header& header : headers) header.displayWindow() = {{0, 0}, {static_cast<int>(kWidth) - 1, tallest}};
  headers.front().insert(kChecksumName, Imf::StringAttribute(checksum(file)));
  for (const auto& [name, value] : file.attributes) headers.front().insert(kPrefix + name, Imf::StringAttribute(value));
  ExrStream stream(path);
  auto output = std::make_unique<Imf::MultiPartOutputFile>(stream, headers.data(), static_cast<int>(headers.size()));
  for (std::size_t i = 0; i < file.tables.size(); ++i) {
    BakeTable padded = file.tables[i];
    const std::size_t rows = rows_of(length_of(padded));
    Imf::FrameBuffer buffer;
    for (auto& [name, values] : padded.integers) insert_slice(&buffer, Imf::UINT, name, &values, rows);
    for (auto& [name, values] : padded.floats) insert_slice(&buffer, Imf::FLOAT, name, &values, rows);
    Imf::OutputPart part(*output, static_cast<int>(i));
    part.setFrameBuffer(buffer);
    part.writePixels(static_cast<int>(rows));
  }
  output.reset();
  stream.close();
}

std::string text_attribute(const Imf::Header& header, const std::string& name) {
  const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  return attribute ? attribute->value() : std::string();
}

std::size_t channels_of(const Imf::Header& header) {
  std::size_t count = 0;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) ++count;
  return count;
}

BakeTable read_part(const std::string& path, Imf::MultiPartInputFile& input, int index) {
  Imf::InputPart part(input, index);
  const Imf::Header& header = part.header();
  BakeTable table;
  table.name = header.hasName() ? header.name() : "";
  const Imath::Box2i window = header.dataWindow();
  const auto rows = static_cast<std::size_t>(window.max.y - window.min.y + 1);
  const std::string count_text = text_attribute(header, kCountName);
  const std::size_t count = std::strtoull(count_text.c_str(), nullptr, 10);
  if (window.min != Imath::V2i(0, 0) || window.max.x != static_cast<int>(kWidth) - 1 || rows > kMaxRows ||
      count > rows * kWidth || count_text.empty() || !can_hold(path, channels_of(header) * rows * kWidth * 4))
    throw Error(path, "part '" + table.name + "' is no table of a bake", "bake it again");
  Imf::FrameBuffer buffer;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (it.channel().type == Imf::UINT) insert_slice(&buffer, Imf::UINT, it.name(), &table.integers[it.name()], rows);
    if (it.channel().type == Imf::FLOAT) insert_slice(&buffer, Imf::FLOAT, it.name(), &table.floats[it.name()], rows);
  }
  part.setFrameBuffer(buffer);
  part.readPixels(0, static_cast<int>(rows) - 1);
  for (auto& [name, values] : table.integers) values.resize(count);
  for (auto& [name, values] : table.floats) values.resize(count);
  return table;
}

}  // namespace

const BakeTable& BakeFile::table(const std::string& path, const std::string& name) const {
  const auto found = std::find_if(tables.begin(), tables.end(), [&](const BakeTable& t) { return t.name == name; });
  if (found == tables.end()) throw Error(path, "the bake has no table '" + name + "'", "bake it again");
  return *found;
}

const std::vector<std::uint32_t>& BakeFile::integers(const std::string& path, const std::string& table_name,
                                                     const std::string& column) const {
  const auto& columns = table(path, table_name).integers;
  const auto found = columns.find(column);
  if (found == columns.end())
    throw Error(path, "table '" + table_name + "' has no whole numbers '" + column + "'", "bake it again");
  return found->second;
}

const std::vector<float>& BakeFile::floats(const std::string& path, const std::string& table_name,
                                           const std::string& column) const {
  const auto& columns = table(path, table_name).floats;
  const auto found = columns.find(column);
  if (found == columns.end())
    throw Error(path, "table '" + table_name + "' has no numbers '" + column + "'", "bake it again");
  return found->second;
}

void save_bake_file(const std::string& path, const BakeFile& file) {
  assert(std::all_of(file.tables.begin(), file.tables.end(), is_even));
  write_atomically(path, [&](const std::string& temporary) {
    try {
      write_parts(temporary, file);
    } catch (const std::exception& e) {
      throw Error(path, std::string("cannot be written: ") + e.what(), "check the folder and the space left");
    }
  });
}

BakeFile load_bake_file(const std::string& path) {
  BakeFile file;
  std::string stored;
  try {
    Imf::MultiPartInputFile input(checked_exr(path));
    for (int i = 0; i < input.parts(); ++i) {
      if (!input.partComplete(i)) throw Error(path, "the bake is truncated", "bake it again");
      file.tables.push_back(read_part(path, input, i));
    }
    const Imf::Header& first = input.header(0);
    stored = text_attribute(first, kChecksumName);
    const std::string prefix = kPrefix;
    for (auto it = first.begin(); it != first.end(); ++it) {
      const std::string name = it.name();
      if (name.starts_with(prefix)) file.attributes[name.substr(prefix.size())] = text_attribute(first, name);
    }
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(path, std::string("is no readable bake: ") + e.what(), "bake it again");
  }
  if (stored != checksum(file)) throw Error(path, "the bake is damaged: its checksum does not fit", "bake it again");
  return file;
}

}  // namespace maquette

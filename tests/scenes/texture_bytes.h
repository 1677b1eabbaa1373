#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace maquette::test {

/// Images as bytes, made without the libraries that read them.
using Pixels = std::vector<std::uint8_t>;

inline void put_big_endian(std::uint32_t value, std::string* out) {
  for (int shift = 24; shift >= 0; shift -= 8) out->push_back(static_cast<char>(value >> shift & 255u));
}

inline std::uint32_t png_checksum(const std::string& text) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : text) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int k = 0; k < 8; ++k) crc = (crc & 1u) != 0 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return ~crc;
}

inline std::string png_chunk(const std::string& name, const std::string& content) {
  std::string out;
  put_big_endian(static_cast<std::uint32_t>(content.size()), &out);
  out += name + content;
  put_big_endian(png_checksum(name + content), &out);
  return out;
}

/// Up to 65,535 bytes in one stored block.
inline std::string zlib_stored(const std::string& content) {
  const auto size = static_cast<unsigned>(content.size());
  std::string out = "\x78\x01\x01";
  for (const unsigned v : {size, ~size}) {
    out.push_back(static_cast<char>(v & 255u));
    out.push_back(static_cast<char>(v >> 8 & 255u));
  }
  std::uint32_t a = 1, b = 0;
  for (const char c : content) {
    a = (a + static_cast<std::uint8_t>(c)) % 65521u;
    b = (b + a) % 65521u;
  }
  out += content;
  put_big_endian(b << 16 | a, &out);
  return out;
}

/// `rows` holds filter bytes and packed samples. `extra` are chunks between IHDR and IDAT.
inline std::string png_bytes(int width, int height, int depth, int color_type, const std::string& rows,
                             const std::string& extra = {}, bool interlaced = false) {
  std::string header;
  put_big_endian(static_cast<std::uint32_t>(width), &header);
  put_big_endian(static_cast<std::uint32_t>(height), &header);
  for (const int v : {depth, color_type, 0, 0, interlaced ? 1 : 0}) header.push_back(static_cast<char>(v));
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + extra + png_chunk("IDAT", zlib_stored(rows)) +
         png_chunk("IEND", {});
}

/// JPEG of one row of 8 x 8 blocks of constant values, [block][component], quantised by 1: decoding is exact up to the
/// colour conversion. `adobe`: the colour transform of Adobe's marker, -1 for none.
inline std::string jpeg_bytes(const std::vector<std::vector<int>>& blocks, bool progressive = false, int adobe = -1) {
  const std::size_t components = blocks[0].size();
  std::string out = "\xff\xd8";
  const auto segment = [&out](int marker, const std::string& content) {
    out.push_back('\xff');
    out.push_back(static_cast<char>(marker));
    out.push_back(static_cast<char>((content.size() + 2) >> 8));
    out.push_back(static_cast<char>((content.size() + 2) & 255u));
    out += content;
  };
  if (adobe >= 0) segment(0xee, std::string("Adobe\0\x64\0\0\0\0", 11) + static_cast<char>(adobe));
  segment(0xdb, std::string(1, '\0') + std::string(64, '\1'));
  std::string frame = std::string("\x08\0\x08", 3);
  frame.push_back('\0');
  frame.push_back(static_cast<char>(8 * blocks.size()));
  frame.push_back(static_cast<char>(components));
  for (std::size_t c = 0; c < components; ++c) frame += static_cast<char>(c + 1) + std::string("\x11\0", 2);
  segment(progressive ? 0xc2 : 0xc0, frame);
  // DC: the twelve categories have codes of four bits. AC: the end of a block is the bit 0.
  std::string dc = std::string("\0\0\0\0\x0c", 5) + std::string(12, '\0');
  for (int i = 0; i < 12; ++i) dc.push_back(static_cast<char>(i));
  segment(0xc4, dc);
  segment(0xc4, std::string("\x10\1", 2) + std::string(16, '\0'));
  std::string scan(1, static_cast<char>(components));
  for (std::size_t c = 0; c < components; ++c) scan += static_cast<char>(c + 1) + std::string(1, '\0');
  segment(0xda, scan + std::string(progressive ? std::string("\0\0\0", 3) : std::string("\0\x3f\0", 3)));

  std::vector<int> bits, last(components, 0);
  const auto put = [&bits](int value, int count) {
    for (int k = count - 1; k >= 0; --k) bits.push_back(value >> k & 1);
  };
  for (const std::vector<int>& block : blocks) {
    for (std::size_t c = 0; c < components; ++c) {
      const int dc_value = 8 * (block[c] - 128), difference = dc_value - last[c];
      last[c] = dc_value;
      int category = 0;
      while (std::abs(difference) >> category != 0) ++category;
      put(category, 4);
      put(difference < 0 ? difference + (1 << category) - 1 : difference, category);
      if (!progressive) put(0, 1);
    }
  }
  const auto flush = [&] {
    while (bits.size() % 8 != 0) bits.push_back(1);
    for (std::size_t i = 0; i < bits.size(); i += 8) {
      int byte = 0;
      for (std::size_t k = 0; k < 8; ++k) byte = 2 * byte + bits[i + k];
      out.push_back(static_cast<char>(byte));
      if (byte == 255) out.push_back('\0');
    }
    bits.clear();
  };
  flush();
  // Without these scans decoders smooth the blocks.
  for (std::size_t c = 0; progressive && c < components; ++c) {
    segment(0xda, "\1" + std::string(1, static_cast<char>(c + 1)) + std::string("\0\1\x3f\0", 4));
    put(0, static_cast<int>(blocks.size()));
    flush();
  }
  return out + "\xff\xd9";
}

}  // namespace maquette::test

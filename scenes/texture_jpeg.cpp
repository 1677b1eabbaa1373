// Through libjpeg: stb_image reads Huffman tables that a damaged file does not define, and TurboJPEG's own interface
// tells only of the last warning and knows only some samplings of chroma.
#include "scenes/texture_jpeg.h"

#include <csetjmp>
#include <cstdint>
#include <cstdio>

// After <cstdio>.
#include <jerror.h>
#include <jpeglib.h>

#include <cstring>
#include <new>

#include "scenes/error.h"

namespace maquette {
namespace {

constexpr const char* kRemedy = "copy or export it again";
/// A small file of many scans would take minutes.
constexpr int kMostScans = 500;
constexpr int kEndOfImage = 0xd9;

/// What the decoder says. Its C code is left by longjmp, so no object with a destructor may lie between.
struct Decoder {
  jpeg_error_mgr errors{};  ///< first: libjpeg hands back a pointer to it
  jpeg_progress_mgr progress{};
  jpeg_decompress_struct info{};
  std::jmp_buf leave{};
  char message[JMSG_LENGTH_MAX] = {};
  bool decoding = false;     ///< past the header
  bool superfluous = false;  ///< bytes that belong to nothing, and hide nothing of the image
};

Decoder& decoder_of(j_common_ptr info) { return *static_cast<Decoder*>(info->client_data); }

[[noreturn]] void stop(j_common_ptr info) {
  Decoder& decoder = decoder_of(info);
  info->err->format_message(info, decoder.message);
  std::longjmp(decoder.leave, 1);
}

/// Warnings that mean lost data end the decoding.
void hear(j_common_ptr info, int level) {
  if (level >= 0) return;
  Decoder& decoder = decoder_of(info);
  switch (info->err->msg_code) {
    case JWRN_EXTRANEOUS_DATA:
      // Within the data of a scan they are damage, unless the image is complete.
      if (decoder.decoding && info->err->msg_parm.i[1] != kEndOfImage) stop(info);
      decoder.superfluous = true;
      break;
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_JPEG_EOF:
    case JWRN_MUST_RESYNC:
    case JWRN_BOGUS_PROGRESSION:
      stop(info);
    default:
      break;
  }
}

void count_scans(j_common_ptr info) {
  if (decoder_of(info).info.input_scan_number > kMostScans) {
    std::snprintf(decoder_of(info).message, JMSG_LENGTH_MAX, "it has more than %d scans", kMostScans);
    std::longjmp(decoder_of(info).leave, 1);
  }
}

/// libjpeg skips segments whose length does not even hold itself. Looks at those before the first scan.
void check_segments(std::span<const std::byte> bytes) {
  const auto byte_at = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
  for (std::size_t i = 2; i + 4 <= bytes.size();) {
    const unsigned marker = byte_at(i + 1);
    if (byte_at(i) != 0xff || marker == 0xff || marker == 0) {  // stray, or fills up
      ++i;
      continue;
    }
    const std::size_t length = byte_at(i + 2) << 8 | byte_at(i + 3);
    if (length < 2) throw Error({}, "is a damaged JPEG image", kRemedy);
    if (marker == 0xda) return;
    i += 2 + length;
  }
}

/// False, with a message, where it cannot be read.
bool read_header(Decoder* decoder, std::span<const std::byte> bytes) {
  if (setjmp(decoder->leave) != 0) return false;
  jpeg_create_decompress(&decoder->info);
  decoder->info.progress = &decoder->progress;
  jpeg_mem_src(&decoder->info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&decoder->info, TRUE);
  return true;
}

bool read_rows(Decoder* decoder, std::uint8_t* rgba) {
  if (setjmp(decoder->leave) != 0) return false;
  jpeg_decompress_struct& info = decoder->info;
  const bool cmyk = info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK;
  info.out_color_space = cmyk ? JCS_CMYK : JCS_EXT_RGBA;
  info.dct_method = JDCT_ISLOW;
  decoder->decoding = true;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = rgba + std::size_t{4} * info.output_width * info.output_scanline;
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  return true;
}

struct Cleaner {
  Decoder* decoder;
  ~Cleaner() { jpeg_destroy_decompress(&decoder->info); }
};

Error undecodable(const Decoder& decoder) {
  return Error({}, std::string("cannot be decoded: ") + decoder.message, kRemedy);
}

/// Adobe stores 255 - C, 255 - M, 255 - Y and 255 - K.
void convert_cmyk(TextureImage* image) {
  for (std::size_t i = 0; i < image->rgba.size(); i += 4) {
    std::uint8_t* texel = &image->rgba[i];
    for (int c = 0; c < 3; ++c) texel[c] = static_cast<std::uint8_t>((texel[c] * texel[3] + 127) / 255);
    texel[3] = 255;
  }
}

}  // namespace

void decode_jpeg(std::span<const std::byte> bytes, const std::function<void(int, int)>& set_size, TextureImage* image,
                 std::vector<std::string>* notes) {
  check_segments(bytes);
  Decoder decoder;
  decoder.info.err = jpeg_std_error(&decoder.errors);
  decoder.errors.error_exit = stop;
  decoder.errors.emit_message = hear;
  decoder.errors.output_message = [](j_common_ptr) {};
  decoder.progress.progress_monitor = count_scans;
  decoder.info.client_data = &decoder;
  const Cleaner cleaner{&decoder};
  if (!read_header(&decoder, bytes)) throw undecodable(decoder);
  if (decoder.info.num_components == 4 && !decoder.info.saw_Adobe_marker)
    throw Error({}, "is a JPEG image of four components without Adobe's marker", "export it as RGB");
  set_size(static_cast<int>(decoder.info.image_width), static_cast<int>(decoder.info.image_height));
  if (!read_rows(&decoder, image->rgba.data())) throw undecodable(decoder);
  if (decoder.superfluous) notes->push_back("has superfluous bytes between the segments of its JPEG data");
  if (decoder.info.out_color_space != JCS_CMYK) return;
  notes->push_back("is a CMYK image; its colours are converted without a profile");
  convert_cmyk(image);
}

}  // namespace maquette

#include <meshoptimizer.h>

#include <exception>

#include "scenes/error.h"
#include "scenes/gltf_document.h"
#include "scenes/parallel.h"

namespace maquette::gltf {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
/// A byte of a stream describes 64 bytes at most (one bit pair of a header for 16 equal bytes): more is not in it.
constexpr std::size_t kMostBytesPerByte = 64;

struct Stream {
  std::size_t view = 0;
  Bytes bytes;
  std::size_t count = 0, stride = 0;
  std::string mode, filter;
};

Stream describe(const Document& document, std::size_t view, const Json& json, const std::string& where) {
  Stream out;
  out.view = view;
  out.count = json["count"].get<std::size_t>();
  out.stride = json["byteStride"].get<std::size_t>();
  out.mode = json["mode"].get<std::string>();
  out.filter = json.value("filter", "NONE");
  const bool of_vertices = out.mode == "ATTRIBUTES", of_triangles = out.mode == "TRIANGLES";
  if (!of_vertices && !of_triangles && out.mode != "INDICES")
    throw Error(where, "mode " + name_text(out.mode) + " is not one of the extension's", kDamaged);
  const bool fits = of_vertices ? out.stride > 0 && out.stride <= 256 && out.stride % 4 == 0
                                : (out.stride == 2 || out.stride == 4) && (!of_triangles || out.count % 3 == 0);
  const bool filtered = (out.filter == "OCTAHEDRAL" && (out.stride == 4 || out.stride == 8)) ||
                        (out.filter == "QUATERNION" && out.stride == 8) || out.filter == "EXPONENTIAL";
  if (!fits || (out.filter != "NONE" && !(of_vertices && filtered)))
    throw Error(where,
                "mode " + out.mode + ", filter " + name_text(out.filter) + ", byteStride " +
                    std::to_string(out.stride) + " and count " + std::to_string(out.count) + " do not go together",
                kDamaged);
  const auto buffer = json["buffer"].get<std::size_t>();
  const auto offset = json.value("byteOffset", std::size_t{0}), length = json["byteLength"].get<std::size_t>();
  const Bytes source = document.buffers[buffer];
  if (offset > source.size() || length > source.size() - offset)
    throw Error(where, "its bytes are outside " + element("buffers", buffer), kDamaged);
  out.bytes = source.subspan(offset, length);
  const std::size_t promised = document.model.bufferViews[view].byteLength;
  if (out.count > kMostBytesPerByte * length || out.count * out.stride > kMostBytesPerByte * length)
    throw Error(where, "does not hold the " + std::to_string(out.count) + " elements that it promises", kDamaged);
  if (out.count * out.stride != promised)
    throw Error(
        where,
        "has " + std::to_string(out.count * out.stride) + " bytes, byteLength promises " + std::to_string(promised),
        kDamaged);
  return out;
}

/// Source: EXT_meshopt_compression, "Mode" and "Filters".
std::vector<std::byte> decode(const Stream& stream, const std::string& where) {
  std::vector<std::byte> out(stream.count * stream.stride);
  const auto* source = reinterpret_cast<const unsigned char*>(stream.bytes.data());
  const std::size_t size = stream.bytes.size();
  int failed = 0;
  if (stream.mode == "ATTRIBUTES") {
    failed = meshopt_decodeVertexBuffer(out.data(), stream.count, stream.stride, source, size);
  } else if (stream.mode == "TRIANGLES") {
    failed = meshopt_decodeIndexBuffer(out.data(), stream.count, stream.stride, source, size);
  } else {
    failed = meshopt_decodeIndexSequence(out.data(), stream.count, stream.stride, source, size);
  }
  if (failed != 0) throw Error(where, "its data cannot be decoded", kDamaged);
  if (stream.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), stream.count, stream.stride);
  if (stream.filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), stream.count, stream.stride);
  if (stream.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), stream.count, stream.stride);
  return out;
}

}  // namespace

bool is_fallback(const Json& buffer) {
  const Json* extension = find_extension(buffer, kMeshopt);
  return extension != nullptr && extension->contains("fallback") && (*extension)["fallback"] == true;
}

void decode_views(Document* document) {
  const auto views = document->root.find("bufferViews");
  if (views == document->root.end()) return;
  std::vector<Stream> streams;
  const auto where_of = [&](std::size_t view) {
    return at(document->path, element("bufferViews", view) + "." + kMeshopt);
  };
  for (std::size_t i = 0; i < views->size(); ++i)
    if (const Json* json = find_extension((*views)[i], kMeshopt); json != nullptr)
      streams.push_back(describe(*document, i, *json, where_of(i)));
  if (streams.empty()) return;
  document->decoded_views.resize(views->size());
  std::vector<std::exception_ptr> failures(streams.size());
  parallel_for(std::size_t{0}, streams.size(), [&](std::size_t i) {
    try {
      document->decoded_views[streams[i].view] = decode(streams[i], where_of(streams[i].view));
    } catch (...) {
      failures[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace maquette::gltf

#pragma once

#include <string>

namespace maquette::test {

enum class MeshCodec { draco, meshopt };

/// Rewrites a file of `save_glb`: the geometry of its primitives compressed without loss, by the codec's own encoder.
/// Throws std::runtime_error.
void compress_glb(const std::string& path, MeshCodec codec);

}  // namespace maquette::test

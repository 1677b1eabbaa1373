#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "review/look.h"

namespace maquette {

/// Changes a source between how a file names it and how the program does: relative to the file, absolute.
using SourceMap = std::function<std::string(const std::string& source)>;

nlohmann::json camera_json(const CameraView& camera);
CameraView camera_from_json(const nlohmann::json& json, const std::string& where);

/// Every value of the look, defaults included; its floats read back as they are.
nlohmann::json look_json(const Look& look, const SourceMap& to_file);
/// Throws Error that names the member under `where`: one that is missing, unknown (with the nearest name) or out of
/// range.
Look look_from_json(const nlohmann::json& json, const std::string& where, const SourceMap& from_file);

}  // namespace maquette

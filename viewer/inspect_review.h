#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace maquette {

/// What a review holds, which of its files are missing or changed, and where its bakes are. Throws Error.
nlohmann::ordered_json inspect_review(const std::string& file);

}  // namespace maquette

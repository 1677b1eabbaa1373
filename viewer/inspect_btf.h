#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace maquette {

/// What a BTF holds and what its factorisation keeps. `source`: with its readings (render/btf/btf_source.h).
nlohmann::ordered_json inspect_btf(const std::string& source);

}  // namespace maquette

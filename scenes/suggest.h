#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace maquette {

/// Levenshtein distance with neighbouring transpositions as one step, case ignored, of the first 200 bytes.
int edit_distance(std::string_view a, std::string_view b);
/// At most `count` of `names`, nearest first; only those within a typing mistake, or with a missing part.
std::vector<std::string> nearest_names(std::string_view name, const std::vector<std::string>& names,
                                       std::size_t count = 3);
/// "did you mean a or b?" when a name is near, otherwise "known: a, b, c" (shortened after a dozen); empty without
/// names.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& names);
/// "a, b, c".
std::string join(const std::vector<std::string>& names, const std::string& separator = ", ");

}  // namespace maquette

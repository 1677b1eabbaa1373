#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace maquette {

/// Values of options as text. `what`: the option, for errors. All throw UsageError.
double parse_number(const std::string& text, const std::string& what);
/// In [min, max].
double parse_in(const std::string& text, const std::string& what, double min, double max);
/// A whole number in [min, max].
std::int64_t parse_count(const std::string& text, const std::string& what, std::int64_t min, std::int64_t max);
/// `count` finite numbers with commas between them; `form` is how the error writes them.
std::vector<double> parse_list(const std::string& text, const std::string& what, std::size_t count,
                               const std::string& form);
/// What is before and behind the first '=', or the last one: names have others.
std::pair<std::string, std::string> parse_pair(const std::string& text, const std::string& what,
                                               const std::string& form, bool last = false);
/// NAME=FILE, both of which may have more of '=': split at the first one behind which a file, a folder or a `builtin:`
/// is; at the first of all where there is none.
std::pair<std::string, std::string> parse_name_and_file(const std::string& text, const std::string& what,
                                                        const std::string& form);

}  // namespace maquette

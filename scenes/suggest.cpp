#include "scenes/suggest.h"

#include <algorithm>
#include <cctype>

#include "scenes/harmless.h"

namespace maquette {

namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::string join_shortened(std::vector<std::string> names, const std::string& separator) {
  constexpr std::size_t kLongest = 80;
  for (std::string& name : names) name = without_middle(name, kLongest);
  return join(names, separator);
}

/// Distance to the nearest of the words of `candidate` (`leather` in `leather-black`).
int word_distance(std::string_view name, const std::string& candidate) {
  int nearest = edit_distance(name, candidate);
  std::size_t begin = 0;
  while (begin < candidate.size()) {
    const std::size_t end = std::min(candidate.find_first_of("-_.: ", begin), candidate.size());
    if (end > begin)
      nearest = std::min(nearest, 1 + edit_distance(name, std::string_view(candidate).substr(begin, end - begin)));
    begin = end + 1;
  }
  return nearest;
}

}  // namespace

int edit_distance(std::string_view first, std::string_view second) {
  // Names come from files and may be as long; the cost is the product of both lengths.
  constexpr std::size_t kCompared = 200;
  const std::string a = lower(first.substr(0, kCompared)), b = lower(second.substr(0, kCompared));
  // Rows i - 2, i - 1 and i of the dynamic programme.
  std::vector<int> before(b.size() + 1), previous(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int substitution = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({previous[j] + 1, row[j - 1] + 1, substitution});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, previous);
    std::swap(previous, row);
  }
  return previous[b.size()];
}

std::vector<std::string> nearest_names(std::string_view name, const std::vector<std::string>& names,
                                       std::size_t count) {
  const int limit = std::max(2, static_cast<int>(name.size()) / 3);
  const std::string wanted = lower(name);
  std::vector<std::pair<int, std::string>> ranked;
  for (const std::string& candidate : names) {
    int distance = word_distance(name, candidate);
    const std::string known = lower(candidate);
    const bool part = wanted.size() >= 3 && known.find(wanted) != std::string::npos;
    const bool begins = wanted.starts_with(known) && known.find_first_not_of('-') + 3 <= known.size();
    if (part || begins) distance = std::min(distance, limit);
    if (distance <= limit) ranked.emplace_back(distance, candidate);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> result;
  for (const auto& [distance, candidate] : ranked) {
    if (result.size() == count) break;
    result.push_back(candidate);
  }
  return result;
}

std::string join(const std::vector<std::string>& names, const std::string& separator) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : separator) + name;
  return text;
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& names) {
  constexpr std::size_t kListed = 12;
  if (names.empty()) return {};
  const std::vector<std::string> near = nearest_names(name, names);
  if (!near.empty()) return "did you mean " + join_shortened(near, " or ") + "?";
  const std::vector<std::string> listed(names.begin(),
                                        names.begin() + static_cast<std::ptrdiff_t>(std::min(kListed, names.size())));
  return "known: " + join_shortened(listed, ", ") + (names.size() > kListed ? ", ..." : "");
}

}  // namespace maquette

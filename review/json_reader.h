#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

namespace maquette {

/// Throws Error.
std::string read_text_file(const std::string& file);

/// A float as the shortest number that reads back as it.
nlohmann::json shortest(float value);

/// Reads the members of one JSON object and insists on all of it: every member that is asked for must be there and of
/// its type, and every member that is there must be asked for. Everything throws Error that names file and member.
class JsonReader {
 public:
  /// `where`: `FILE: look.camera`, for messages. Both outlive the reader.
  JsonReader(const nlohmann::json& json, std::string where);

  bool has(const std::string& key);  ///< counts as asked for
  const nlohmann::json& member(const std::string& key);
  std::string text(const std::string& key);
  bool flag(const std::string& key);
  double number(const std::string& key, double min, double max);
  float real(const std::string& key, float min = -1e30f, float max = 1e30f);
  int count(const std::string& key, int min, int max);
  /// `size` numbers.
  std::vector<float> reals(const std::string& key, std::size_t size);
  std::vector<std::string> texts(const std::string& key);
  std::string choice(const std::string& key, const std::vector<std::string>& names);
  const nlohmann::json& list(const std::string& key);
  const nlohmann::json& object(const std::string& key);
  std::string where(const std::string& key) const;
  /// Refuses members that nobody asked for, with the nearest known name.
  void finish() const;

 private:
  const nlohmann::json& json_;
  std::string where_;
  std::set<std::string> known_;
};

}  // namespace maquette

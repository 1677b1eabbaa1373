#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "viewer/report/data.h"

namespace maquette::report {

/// Results so far, on disk as `progress.json` of the report's folder: rewritten after each one, so that an interrupted
/// run loses at most one.
class Journal {
 public:
  /// Reads the file if there is one. A damaged file is renamed to progress.json.damaged, and `note` says so.
  explicit Journal(const std::string& folder);
  const std::string& note() const { return note_; }

  std::optional<Point> find_point(const std::string& key) const;
  std::optional<ReferenceEntry> find_reference(const std::string& key) const;
  /// These write the file. They throw Error when it cannot be written; the old file then stays.
  void add_point(const std::string& key, const Point& point);
  void add_reference(const std::string& key, const ReferenceEntry& entry);

 private:
  void save() const;
  std::string path_, note_;
  std::map<std::string, Point> points_;
  std::map<std::string, ReferenceEntry> references_;
};

nlohmann::ordered_json point_json(const Point& point);
/// Throws nlohmann's exceptions when something is missing.
Point point_from_json(const nlohmann::ordered_json& json);
nlohmann::ordered_json reference_json(const ReferenceEntry& entry);

}  // namespace maquette::report

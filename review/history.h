#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

namespace maquette {

/// Undo and redo of a JSON document: what each change adds and takes, as JSON patches (RFC 6902). Every change is also
/// a record, one line of a journal, by which another history can follow.
class History {
 public:
  static constexpr std::size_t kDepth = 1000;
  using Json = nlohmann::json;
  using Sink = std::function<void(const Json& record)>;

  explicit History(Json document) : document_(std::move(document)) {}
  /// Called with each record after the change that it describes.
  void set_sink(Sink sink) { sink_ = std::move(sink); }

  const Json& document() const { return document_; }
  /// A step from the document to `now`; nothing when they are equal. Moves of the camera that follow one another are
  /// one step, but for those that are `apart`: the camera was put somewhere. Steps that were undone are dropped.
  void record(const Json& now, bool apart = false);
  /// A change that is no step of its own: it belongs to the last one, which is dropped where nothing of it is left.
  /// What was undone is dropped.
  void amend(const Json& now);
  bool can_undo() const { return done_ > 0; }
  bool can_redo() const { return done_ < steps_.size(); }
  bool undo();
  bool redo();
  std::size_t undo_count() const { return done_; }
  std::size_t redo_count() const { return steps_.size() - done_; }

  /// Follows a record of another history. Throws std::exception when it does not fit; this is then as before.
  void follow(const Json& record);
  /// Records that lead a new history to this one, from `first_document`.
  std::vector<Json> records(Json* first_document) const;

 private:
  struct Step {
    Json forward, backward;
    bool apart = false;   ///< what follows is another step in any case
    bool camera = false;  ///< nothing but the camera at hand, and not apart
  };
  void emit(const Json& record) {
    if (sink_) sink_(record);
  }
  void push(Step step);

  Json document_;
  std::deque<Step> steps_;
  std::size_t done_ = 0;
  Sink sink_;
};

}  // namespace maquette

#pragma once

#include "render/prt/transfer_bake.h"
#include "render/reference/path_scene.h"
#include "render/scene_state/facts.h"
#include "render/technique/settings.h"

namespace maquette {

/// What the scene and its view decide about transfer, besides settings.
struct TransferInput {
  std::shared_ptr<const Scene> scene;  ///< edits included, with the materials to show
  std::shared_ptr<const FlatGeometry> geometry;
  int variant = -1;
  std::vector<bool> nodes;  ///< [node] whether its parts get transfer; empty: all
  Settings settings;
};

/// What is kept between jobs: measured materials.
struct TransferMemory {
  MeasuredLibrary library;
  std::shared_ptr<const TransferBake> bake;
};

/// Whether a scene gets the joint form, and why, for the plan; by the most components that its materials may get.
struct TransferForm {
  bool joint = false;
  std::string reason;
};
TransferForm choose_transfer_form(const Settings& settings, const SceneFacts& facts);

/// Why precomputed transfer cannot hold an item with this material, or nothing.
std::string check_transfer_part(const FlatGeometry& geometry, const DrawItem& item, const Material& material);

/// Opaque, visible items of the wanted nodes and of those that `prt.parts` names, with what is below them.
std::vector<std::size_t> find_transfer_items(const TransferInput& input);

/// The job for an input; its folder: below `folder`, or else where `prt.bake` or the cache keep it. Loads BTFs. Throws
/// Error, also for a material that transfer cannot hold, by its name.
TransferJob make_transfer_job(const TransferInput& input, const std::string& folder, MeasuredLibrary* library,
                              const std::atomic<bool>* cancel = nullptr);

}  // namespace maquette

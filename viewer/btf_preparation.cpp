#include "viewer/btf_preparation.h"

#include <cstdio>
#include <set>

#include "render/btf/btf_source.h"
#include "render/technique/registry.h"
#include "viewer/interrupt.h"
#include "viewer/print.h"
#include "viewer/progress_lines.h"

namespace maquette {

BtfTask print_btf_task(const std::atomic<bool>& cancel) {
  BtfTask task;
  task.progress = print_progress();
  task.cancelled = [&cancel] { return cancel.load(); };
  return task;
}

void prepare_btf(const std::string& source) {
  if (!is_btf_source(source)) return;
  const InterruptGuard guard;
  load_material_table(source, print_btf_task(InterruptGuard::flag()));
}

void prepare_btfs(const SceneOptions& options, const Scene& scene, bool draws) {
  std::set<std::string> sources;
  for (const auto& [name, source] : options.materials) sources.insert(source);
  for (const Material& material : scene.materials) sources.insert(material.measured);
  const Registry& registry = builtin_registry();
  const Technique& mode = registry.find_mode(options.mode);
  const bool exact = !draws || mode.can.traces_picture || mode.own_bake;  // whose bakes hold whole BTFs
  for (const std::string& source : sources) {
    if (!is_btf_source(source)) continue;
    prepare_btf(source);
    if (exact) continue;
    const Technique* other = registry.first_that(TechniqueKind::mode, &Capabilities::traces_picture);
    print_line(stderr, "note: %s is a BTF, of which mode %s draws the mean over its texels%s\n", source.c_str(),
               options.mode.c_str(), other ? ("; --mode " + other->name + " draws all of it").c_str() : "");
  }
}

}  // namespace maquette

#pragma once

#include <vector>

#include "render/gl/context.h"
#include "viewer/report/data.h"

namespace maquette::report {

/// What a time depends on: program, processor, cores, memory, system, present load, graphics device.
std::vector<NamedValue> describe_machine(const DeviceInfo& device);

}  // namespace maquette::report

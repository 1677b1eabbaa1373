#pragma once

#include <array>

namespace maquette {

/// What figures of panes leave out, said beside them on the panel and in files.
inline constexpr std::array<const char*, 5> kNotModelled{
    "scatter on and in the pane (dust, scratches, haze)", "coatings, interference and films of the pane",
    "polarisation of the light before it meets the pane", "the shift of what is seen through the pane",
    "glare inside the eye"};

}  // namespace maquette

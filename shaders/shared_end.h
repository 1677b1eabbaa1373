// Closes what shared_begin.h opened.
}  // namespace
}  // namespace maquette::shader
// NOLINTEND
#pragma GCC diagnostic pop

// Number of the invocation in a list that is dispatched in one dimension: drivers promise only 65,535 groups along x, which a list
// of 4 million entries exceeds, so long lists are folded into rows of groups (Renderer::Impl::dispatch_list, arguments.comp).
const uint kGroupsPerRow = 32768u;
uint linear_id() {
  return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}

#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/bandwidth/progressive.h"
#include "render/bandwidth/turning.h"
#include "render/bezier/patch_fit_store.h"
#include "render/environment_buffers.h"
#include "render/frame_constants.h"
#include "render/frame_targets.h"
#include "render/gl/context.h"
#include "render/indirect/indirect_buffers.h"
#include "render/lights/light_buffers.h"
#include "render/lookup_mode.h"
#include "render/material_store.h"
#include "render/octree/octree_store.h"
#include "render/pass_timer.h"
#include "render/program_cache.h"
#include "render/reference/worker.h"
#include "render/reflections/coarse_patches.h"
#include "render/reflections/reflector_technique.h"
#include "render/reflections/skipping.h"
#include "render/renderer.h"
#include "render/scene_buffers.h"
#include "render/visibility/visibility_buffers.h"

namespace maquette {

/// As text, in whole percent.
std::string percent(double fraction);

/// Mode reference: what it traces and the picture so far.
struct ReferenceFrame {
  std::uint32_t scene_epoch = 0;
  FrameRequest request;
  ReferenceWorker::News news;
  Texture texture;  ///< of the picture, made when it is shown
  bool texture_stale = true;
  // In batch:
  std::shared_ptr<const PathScene> scene;
  MeasuredLibrary library;
  std::optional<ReferencePicture> picture;
  // In a window:
  std::unique_ptr<ReferenceWorker> worker;
};

/// All that raster, G-buffer and curvature depend on: while it stays the same, they need not be drawn again.
struct SurfaceKey {
  CameraView camera;
  std::uint32_t epoch = 0;
  bool texture_bandwidth = false;
  bool operator==(const SurfaceKey&) const = default;
};

/// What each grid point shows of panes, kept with the G-buffer (shaders/glass/kept.glsl).
struct KeptPanes {
  std::string visibility;  ///< that it was recorded with
  bool complete = false;   ///< false: there is more than fits, and panes are drawn as ever
  Texture heads, layer_view;
  Buffer layers;
  TileList covered_tiles, bare_tiles;  ///< of surfaces: with a pane before them somewhere, and without
};

/// All that the hits of the mirrored rays depend on.
struct TracedKey {
  SurfaceKey surfaces;
  std::uint32_t epoch = 0;
  std::string technique;
  std::vector<std::string> named;
  Settings settings;
  bool operator==(const TracedKey&) const = default;
};

/// All that the sky's points depend on besides the G-buffer and the environment.
struct SkyKey {
  float rotation_rad = 0.0f, scale = 0.0f;
  bool in_picture = false;  ///< in the picture itself, or in the grid that it is filtered from
  bool operator==(const SkyKey&) const = default;
};

/// All that the indirect light of the points depends on besides the G-buffer.
struct IndirectDrawn {
  std::uint32_t epoch = 0;       ///< of everything but indirect light and paint
  std::uint32_t paint_news = 0;  ///< swaps of paint so far
  std::uint32_t serial = 0;      ///< of the bake
  bool operator==(const IndirectDrawn&) const = default;
};

/// Every `step`-th tile of a list from `first` on.
struct TileShare {
  int first = 0, step = 1;
};

/// What a frame predicts: a share of the tiles while the light turns, those that were repainted after a swap.
struct PredictedPart {
  const TileList& tiles;
  TileShare share = {};
  /// Samples will not draw the sun: it is no part of their variance.
  bool sky_variance = false;
};

/// Which points a frame shades: those that the prediction asks for, by what was measured while nothing moves, or the
/// repainted ones alone.
struct MarkRule {
  std::optional<RefineRates> refine = {};
  bool repainted = false;
};

/// The tiles whose prediction and marks are renewed in this frame.
TileShare renewed_share(const Turn& turn);

/// Triangles of panes that may cover themselves, from back to front.
struct PaneOrder {
  glm::vec3 eye{0.0f};
  std::uint32_t geometry_epoch = 0;
  std::vector<std::size_t> items;            ///< that were looked at
  std::map<std::size_t, std::size_t> first;  ///< item -> place in `indices`, for those that need it
  Buffer indices;
};

/// What an item of raster_glass is made of.
struct GlassKind {
  bool texture = false, surface = false, pane = false;
  bool record = false;  ///< for KeptPanes
  /// What of a reflector it shows besides the sky; `both`: a second image too.
  enum class Reflected { none, front, both, mirror } reflected = Reflected::none;
  bool hatched = false;  ///< where the technique does not vouch for what is reflected
};

struct Renderer::Impl {
  DeviceInfo device = query_device();
  ProgramCache programs;
  Buffer frame_block = Buffer("frame constants", sizeof(FrameConstants));
  std::shared_ptr<const Scene> scene;
  std::optional<SceneBuffers> buffers;
  SceneFacts facts;
  int facts_variant = -2;    ///< of `facts`; -2: to be counted anew
  int buffers_variant = -1;  ///< of `buffers`
  MaterialStore materials;
  std::map<std::string, std::string> overrides;  ///< material name (or `*`) -> source
  std::vector<Material> effective;               ///< the scene's materials with the overrides
  std::vector<int> slots;                        ///< BRDF slot of each effective material, and of the default one
  std::optional<EnvironmentBuffers> environment;
  VisibilityBuffers visibility;
  IndirectBuffers indirect;
  std::uint32_t bounce_epoch = 0;    ///< raised by every change of what colours or emits light, geometry included
  std::uint32_t indirect_epoch = 0;  ///< bounce_epoch of the bake's input
  int indirect_variant = -2;
  OctreeStore octree;
  int frames_without_octree = 0;       ///< since a plan wanted it
  std::uint32_t geometry_epoch = 0;    ///< raised by every change of what may occlude
  std::optional<LightBuffers> lights;  ///< empty when nothing shines
  bool lights_stale = true;
  Texture irradiance;  ///< what a white Lambertian shows under the environment; made when something blends
  Texture near_terms;  ///< of the prediction: bandwidth of masks and near lights; [grid / 2]
  std::optional<PaneOrder> pane_order;
  std::optional<KeptPanes> kept_panes;          ///< of the G-buffer in `targets`; empty: not recorded yet
  GlName<FramebufferTraits> glass_framebuffer;  ///< the radiance image over the depth buffer
  std::map<std::string, std::unique_ptr<LookupMode>> lookup_modes;  ///< made when first drawn with
  std::optional<FrameTargets> targets;
  std::optional<Progressive> progressive;  ///< mode bandwidth, while pictures accumulate
  std::optional<DrawnLight> drawn_light;
  float sample_scale = 1.0f;                  ///< of the lists at hand, while the light turns
  std::optional<TurnHistory> history;         ///< mode bandwidth, from frame to frame while nothing but the light turns
  std::uint32_t indirect_news = 0;            ///< changes of `epoch` by indirect light alone
  std::uint32_t paint_news = 0;               ///< changes of `epoch` by measured tables of materials alone
  std::vector<bool> repainted;                ///< by material: another measured table since the frame before
  std::optional<std::uint32_t> drawn_points;  ///< points_epoch() that `targets` holds points of; empty: nothing to keep
  std::optional<std::uint32_t> light_list_seed = 0;  ///< whose first light samples are drawn; empty: later ones
  std::vector<Reflector> reflectors;                 ///< of the last request; empty when reflections are off
  std::vector<std::string> reflectors_named;         ///< what they were found for
  std::uint32_t reflectors_epoch = 0;                ///< epoch + 1 that they were found in; 0: never
  Buffer reflector_block;                            ///< patches of the reflectors, std140
  CoarsePatches coarse_patches;                      ///< of the scene, while there are reflectors
  std::optional<std::uint32_t> coarse_epoch;         ///< geometry_epoch that they are of
  Buffer coarse_indices;
  bool reflectors_fitted = false;   ///< their curved meshes have patches
  PatchFitStore patch_fits;         ///< of these
  std::string fitting;              ///< names of reflectors that are left out until theirs are there
  bool reflectors_glossy = false;   ///< those that are only glossy were let pass
  Buffer fit_triangles, fit_reach;  ///< [triangle of them], [patch]: as shaders/reflections/rays.comp has them
  Texture fit_triangle_view;
  Buffer ghost_reach;                   ///< by reflector, as ReflectionFrame has it
  FrameConstants reflection_constants;  ///< at the size of the reflected picture
  Buffer reflection_block;
  std::optional<ReflectionTargets> reflection;
  std::optional<TracedKey> traced;          ///< what the hits in `reflection` are of; empty: nothing that may be kept
  std::optional<TracedKey> tracing;         ///< the same of this frame, until its hits are there
  bool reflections_kept = false;            ///< in this frame
  std::optional<ReflectionTargets> ghost;   ///< the second image of panes, while it is drawn
  std::optional<ReflectionTargets> probes;  ///< the same of fewer rays, while some are not followed
  std::map<std::string, std::unique_ptr<ReflectorTechnique>> reflector_techniques;  ///< made when first drawn with
  bool skips = false;                       ///< some rays of this frame are not followed
  std::optional<Skipping> skipping;         ///< while mirrored rays may be left out
  std::optional<ReflectionTargets> glossy;  ///< what glossy opaque surfaces mirror, while they do
  TileList glossy_tiles;                    ///< where there may be such
  Texture glossy_light;                     ///< RGBA32F, cd/m2: what that changes at each point of the grid
  std::unique_ptr<ReflectorTechnique> glossy_technique;
  std::optional<TracedKey> glossy_traced;  ///< what the hits in `glossy` are of
  bool glossy_kept = false;                ///< in this frame
  int glossy_frames = 0;                   ///< whose light `glossy` holds the mean of
  FrameConstants constants{};
  ReferenceFrame reference;
  bool interactive = false;
  FrameRequest last_request;
  int accumulated = 0;
  std::uint32_t epoch = 0;  ///< raised by every change of scene, materials or environment
  std::uint32_t drawn_epoch = 0;
  std::uint32_t surface_epoch = 0;                 ///< raised by every change of what the G-buffer holds
  std::optional<SurfaceKey> drawn_surfaces;        ///< what the G-buffer in `targets` shows; empty: nothing yet
  bool keeps_surfaces = false;                     ///< the G-buffer is that of an earlier frame
  int weights_levels = -1;                         ///< that the weights of upsampling were found for; -1: none
  bool open_found = false;                         ///< what the masks leave open (find_open) holds
  std::optional<IndirectDrawn> indirect_drawn[2];  ///< what FrameTargets::indirect holds
  bool points_hold_mean = false;                   ///< the points of the last frame are those of the mean of all frames
  bool composes_in_picture = false;  ///< the frame at hand, and not in the grid that the picture is filtered from
  std::optional<SkyKey> drawn_sky;   ///< what the sky's points show; empty: to be drawn
  Texture slot_texture;              ///< of settle_slots()
  FramePlan last_plan;
  std::size_t shaded_points = 0, shading_samples = 0, visible_points = 0, continued_points = 0;

  void require_ready() const;
  void update_facts(int variant);
  /// All of the facts that changes when a material takes another measured table.
  void recount_tables();
  const Material& material_of_item(std::size_t item) const;
  bool shows_both_sides(std::size_t item) const;
  void take_visibility();
  /// Starts or uploads the bake that the plan wants; while there is none, the plan says so instead.
  void update_visibility(FramePlan* plan);
  /// The same for light by way of other surfaces; needs the visibility bake first.
  void update_indirect(const FrameRequest& request, FramePlan* plan);
  std::shared_ptr<const IndirectInput> make_indirect_input(int variant) const;
  /// Starts or uploads the octree that the plan wants, and drops one that it does not; while there is none, the plan
  /// says so instead.
  void update_octree(const FrameRequest& request, FramePlan* plan);
  /// In a window, for some frames, what the camera may turn back to any moment; the plan says so.
  bool keep_octree(const std::string& technique, FramePlan* plan);
  void update_cell_brdfs(const Settings& settings, const std::function<OctreeJob()>& make_octree, FramePlan* plan);
  std::vector<bool> transmitting_items() const;
  std::vector<Passage> passages() const;  ///< of each item, as far as it transmits
  void upload_materials();
  /// Before the first frame of a picture: room for what it will know of its points, or none.
  void prepare_accumulation(const FramePlan& plan, bool accumulate);
  /// Draws the light samples anew.
  void renew_light_list(std::uint32_t seed);
  /// The same when a point that takes `count` more samples after its first `begin` would come round the list.
  void renew_light_list_for(std::int64_t begin, std::int64_t count, std::uint32_t seed);
  /// `passing_density`: of points, over that of other frames, where what is drawn stands for an instant only.
  void prepare_constants(const FrameRequest& request, const FramePlan& plan, std::optional<float> passing_density,
                         int samples, int chunk);
  /// Of all that the points of a material depend on besides its own paint.
  std::uint32_t points_epoch() const { return epoch - indirect_news - paint_news; }
  /// The points of the frame before hold where no paint was swapped.
  bool keeps_points(const FrameRequest& request, const FramePlan& plan, bool accumulate) const;
  /// Lists the tiles that show a material with another paint, and forgets what was accumulated of its points.
  /// `painted`: there may be some.
  void find_repainted(bool painted, PassTimer* timer);
  /// False, and the plan says so, when the G-buffer of the frame before still holds.
  bool needs_gbuffer(const FrameRequest& request, FramePlan* plan);
  void draw_gbuffer(const FramePlan& plan, PassTimer* timer);
  void raster();
  /// Lists the tiles, and empties what passes over them read of their neighbours.
  void find_tiles();
  /// Binds the lists that a shader fills. `second` may be null, here and after it ran.
  const Program& begin_tile_lists(const char* shader, const TileList& first, const TileList* second);
  void end_tile_lists(TileList* first, TileList* second);
  /// What the frame goes on from, if only the light has turned. `keeps`: its own points are kept for the next one.
  Turn begin_turn(const FrameRequest& request, const FramePlan& plan, bool keeps, bool accumulate);
  void predict(const FramePlan& plan, const PredictedPart& part, PassTimer* timer);
  /// Mode bandwidth where pictures do not accumulate: two rounds of samples, and what is left of earlier frames.
  void shade_scheduled(const FramePlan& plan, const Turn& turn, PassTimer* timer);
  void schedule_band(const FramePlan& plan, std::size_t band, const Turn& turn, unsigned* counters);
  /// Items `first` to `first + count` of a list of schedule_band.
  void shade_items(const FramePlan& plan, int list, const Turn& turn, bool looks_back, unsigned first, unsigned count);
  /// The sun's light at the points of a list, where the environment has one.
  void shade_sun(const FramePlan& plan, int list, const Turn& turn, unsigned points);
  void shade_scheduled_band(const FramePlan& plan, std::size_t band, const Turn& turn, PassTimer* timer);
  void bind_lists();
  /// What baked masks leave open at the points, for passes that mark; where it is known, of repainted tiles alone.
  void find_open(const FramePlan& plan, bool repaints);
  void shade(const FramePlan& plan, int chunk, const MarkRule& rule, PassTimer* timer);
  void shade_band(const FramePlan& plan, std::size_t band, int chunk, const MarkRule& rule, PassTimer* timer);
  /// Shades the items of both lists (as long as `counters` says) and gathers them into the bound radiance.
  void shade_lists(const FramePlan& plan, const unsigned* counters, ShaderVariant (*variant)(const FramePlan&, int),
                   const Program& gather);
  /// Some rows of the reflected picture. `panes`: bit k set where reflector k is one; their pixels take fewer samples
  /// than those of mirrors.
  void shade_reflected_rows(const FramePlan& plan, int first_row, int rows, int panes);
  void update_reflectors(const FrameRequest& request);
  void forget_reflectors();
  void fit_reflectors();
  void upload_reflectors();
  void note_fits(FramePlan* plan) const;
  CameraFrame camera_frame(const FrameRequest& request) const;
  ViewInfo view_info(const FrameRequest& request) const;
  /// Whether a mesh among the reflectors has patches fitted to it.
  bool any_fitted() const;
  int reflectors_in_view(const FrameRequest& request) const;
  int reflector_of_item(std::size_t item) const;
  /// Sorts the triangles of those items that need it, if the eye or they have moved.
  void order_panes(const std::vector<std::size_t>& items);
  /// Opaque reflectors are drawn with the panes, not with the opaque surfaces.
  bool is_mirror(std::size_t item) const;
  void reflect(const FramePlan& plan, const FrameRequest& request, PassTimer* timer);
  /// `some`: only those that matter; `ghost`: mirrored by the back faces; `glossy`: by opaque surfaces.
  enum class RayKind { all, some, ghost, glossy };
  /// Makes them anew where they are not of the grid's size.
  void fit_targets(int divisor, std::optional<ReflectionTargets>* reflected) const;
  /// [item] opaque, and what of it mirrors is no rougher; mirrors that are reflectors too.
  std::vector<bool> glossy_items(float roughness) const;
  std::vector<std::size_t> named_glossy_items(const FrameRequest& request) const;
  int glossy_in_view(const FrameRequest& request) const;
  /// Drops the pass, and the plan says so, while what it needs is not there yet; frees what is not needed.
  void update_glossy(FramePlan* plan);
  void set_glossy(const Program& program, const FrameRequest& request) const;
  /// Lists the tiles, and clears what passes over them leave out.
  void find_glossy(const FrameRequest& request);
  void cast_glossy_rays(const FrameRequest& request);
  /// Fills `glossy_light`.
  void reflect_glossy(const FramePlan& plan, const FrameRequest& request, PassTimer* timer);
  /// The panes' mirrored rays.
  void cast_rays(RayKind kind, const FrameRequest& request, PassTimer* timer);
  /// The frame block for pixels of the reflected picture.
  void set_reflection_constants(const FrameRequest& request);
  /// Follows few rays, and marks those that need not be followed.
  void drop_unseen_rays(const FramePlan& plan, const FrameRequest& request, PassTimer* timer);
  /// From rays to radiance.
  void follow_rays(RayKind kind, const FramePlan& plan, const FrameRequest& request, PassTimer* timer);
  /// One reflected picture, a point for `divisor` x `divisor` of the grid.
  void reflect_at(int divisor, RayKind kind, const FramePlan& plan, const FrameRequest& request, PassTimer* timer);
  /// The reflected picture alone, or a channel of `ReflectionTargets::effort`, 2: its doubt; alpha 0 outside the
  /// reflectors. Throws Error when none was drawn.
  /// Whether the hits of the frame before hold, so that they are only shaded anew.
  void keep_reflections(const FrameRequest& request, FramePlan* plan);
  Image read_reflection(int channel) const;
  Image read_reflected_distances() const;  ///< m from the eye by way of the reflector, 0 for the sky
  Image read_ghost();                      ///< the second image alone
  Image read_glossy() const;               ///< what their rays met, cd/m2; alpha 0 where none is
  Image read_skipped() const;              ///< 1 where the mirrored ray was not followed
  void draw_panes(ReflectionTargets* targets_of_panes);
  void update_coarse_patches();
  /// With the bound program and vertex array: an item's own triangles, or a coarser level of its patch.
  void draw_level(std::size_t item, const CoarsePatch::Level* level) const;
  /// Those that show a reflector, or that have rays.
  void list_tiles(ReflectionTargets* t, bool rays);
  /// Bounds of what the panes mirror in this frame. False, and the plan says so, when every ray is to be followed.
  bool update_skipping(FramePlan* plan, const FrameRequest& request);
  bool update_skip_geometry();
  void update_skip_light(const FramePlan& plan, const FrameRequest& request);
  int lobe_of(std::size_t material, std::vector<LobeBound>* lobes);
  void draw_cover();
  void bind_ghost(const Program& rays, const Settings& settings);
  void bind_skipping(const Program& rays, float contrast);
  void shade_reflections(const FramePlan& plan, RayKind kind, PassTimer* timer);
  void shade_by_lookup(const LookupModeInfo& mode, PassTimer* timer);
  /// Of each grid point the share of what it shows that was interpolated from others.
  std::vector<float> borrowed_shares() const;
  /// What the frames so far say about the next one's sample counts.
  RefineRates measure_deviations();
  /// Light samples come from a list that goes round: drawn anew when the typical point comes round it (`rounds` times).
  /// Every point then begins another sequence, at the price of an error that falls more slowly, so that a few hungry
  /// points see it more than once, unless they are where the samples go.
  void renew_light_list_after(double rounds, std::uint32_t seed);
  /// Of the finest level's points, those that are to be shaded without need by this frame.
  float scout_share() const;
  /// `own`: points that were shaded take part in what is interpolated at them.
  void fill(bool own, const TileList& tiles, PassTimer* timer);
  void list_quads();
  /// `lanes`: invocations a quad.
  void dispatch_quads(const Program& program, const QuadList& list, int lanes);
  FrameStats render_reference(const FrameRequest& request, FramePlan plan, bool accumulate);
  void trace_reference(const FrameRequest& request, bool accumulate);
  void watch_reference(const FrameRequest& request);
  Pick pick_traced(int x, int y) const;
  bool shows_reference() const { return last_plan.mode == "reference" && reference.news.mean.width > 0; }
  /// The finished picture for the eye.
  const Texture& picture();
  /// The picture is the mean of several points a pixel that are still known apart.
  bool points_are_picture() const { return !shows_reference() && targets->side > 1 && points_hold_mean; }
  Scene edited_scene() const;  ///< with the effective materials and hidden nodes
  /// `tiles`: those to be drawn anew where light is of the bake that is shown already.
  void add_indirect(const TileList& tiles, PassTimer* timer);
  void bind_indirect(const Program& program, const IndirectKey& key) const;
  void compose(const FramePlan& plan, const FrameRequest& request, float blend, PassTimer* timer);
  void draw_sky(const FramePlan& plan, const FrameRequest& request, bool panes);
  const Texture& under_panes() const;  ///< the image that panes are drawn over
  /// Panes, blended surfaces and mirrors in view, from back to front.
  std::vector<std::size_t> glass_items() const;
  /// Whether `kept_panes` holds all that is to be drawn; recorded first where that is known to last.
  bool keep_panes(const FramePlan& plan, const FrameRequest& request);
  /// Of the item's material, or -1.
  int base_color_texture(std::size_t item) const;
  GlassKind glass_kind(const FramePlan& plan, const FrameRequest& request, std::size_t item) const;
  void raster_glass(const FramePlan& plan, const FrameRequest& request, const std::vector<std::size_t>& items,
                    bool record);
  void bind_kept_panes(const Program& program, float rotation_rad) const;
  void dispatch(const Program& program, int x, int y);
  /// As many groups as needed for `count` invocations of 64, folded as shaders/shading/linear_id.glsl unfolds them.
  void dispatch_list(const Program& program, int count);
  /// Over the tiles of a list, 2^shift invocations each; `band`: its tiles only.
  void dispatch_tiles(const Program& program, const TileList& list, int shift, std::optional<std::size_t> band = {},
                      TileShare share = {});
  void bind_frame() const;
  /// Gives all texture slots of compute programs the sampler state that nearly all textures share. Mesa leaves in the
  /// slot of a buffer texture what the program before had there, and a software device compiles a program anew for each
  /// state that it meets: half a second for the large ones, in some later frame.
  void settle_slots();
};

ShaderVariant shade_variant(const FramePlan& plan, int measured);
/// `textures`: points are kept without their base factor (shaders/bandwidth/base_factor.glsl).
ShaderVariant gather_variant(bool accumulate, bool textures);
/// The same for the points that shaders/turning/schedule.comp lists; `looks_back`: they may go on from earlier frames.
ShaderVariant scheduled_shade_variant(const FramePlan& plan, bool measured, bool looks_back, bool sun);
/// Of turning/sun.comp.
ShaderVariant sun_variant(const FramePlan& plan, bool measured);
std::vector<ShaderVariant> turning_shader_variants();
ShaderVariant resolve_variant(bool textures, bool texture_bandwidth, bool colors);
ShaderVariant present_variant(int side);
/// The shaders' VISIBILITY: 0 none, 1 baked, 2 traced.
std::string visibility_define(const FramePlan& plan);
std::vector<ShaderVariant> glass_shader_variants();
std::vector<ShaderVariant> reflection_shader_variants();
ShaderVariant glossy_variant(bool measured, bool indirect);
ShaderVariant glossy_rays_variant(bool measured);
ShaderVariant glossy_tiles_variant(bool measured);
/// Points of the grid along one side of a pixel of the reflected picture.
int reflection_divisor(const Settings& settings);

}  // namespace maquette

#include "render/frame/vocabulary.h"

namespace maquette {

namespace {

using Kind = Word::Kind;

std::vector<Word> pass_words() {
  return {
      {Kind::pass, "list_lights",
       "preparation: the lists that samples of lights and emissive surfaces are chosen from"},
      {Kind::pass, "build_shadow_rays",
       "preparation: starts to build what shadow rays may meet, or takes it over when it is done"},
      {Kind::pass, "bake_visibility", "preparation: starts the bake of visibility, or uploads it when it is done"},
      {Kind::pass, "bake_indirect", "preparation: the same for indirect light"},
      {Kind::pass, "build_octree", "preparation: the same for the octree"},
      {Kind::pass, "bake_cells", "preparation: the same for the BRDFs of its cells"},
      {Kind::pass, "raster", "draws triangle numbers and depth; skipped while camera and surfaces stay"},
      {Kind::pass, "gbuffer", "normals and materials, textures applied, of the visible points; skipped with `raster`"},
      {Kind::pass, "mark", "lists the points that are shaded, with their sample counts"},
      {Kind::pass, "shade", "the shading samples or lookups themselves"},
      {Kind::pass, "indirect",
       "indirect light, baked per vertex (16 bytes each, 32 where backs are seen), at every visible point; skipped "
       "while "
       "bake and surfaces stay"},
      {Kind::pass, "glossy", "what glossy opaque surfaces mirror of others (`reflections.glossy`)"},
      {Kind::pass, "compose", "the sky, emission, indirect light, and the panes where they are kept with the G-buffer"},
      {Kind::pass, "panes", "the reflectors in view and the mirrored ray of each of their pixels"},
      {Kind::pass, "skip", "which mirrored rays need not be followed (`reflections.skip`)"},
      {Kind::pass, "rays", "the mirrored rays traced, on the processor or through the octree on the GPU"},
      {Kind::pass, "projection",
       "the scene projected into the patches or triangles of the reflectors, and the nearest that each pixel's ray "
       "meets; "
       "flat ones by the mirrored eye"},
      {Kind::pass, "draw_rays", "rays from each point to what may light it, and the light that they bring"},
      {Kind::pass, "trace_rays", "what lies between, panes and cut-outs included, traced on the processor"},
      {Kind::pass, "reflected gbuffer", "normal and material, textures applied, of what the mirrored rays hit"},
      {Kind::pass, "reflected shade", "the hits shaded, by the mode of the part that is hit"},
      {Kind::pass, "blended", "shades the layers of blended surfaces, from front to back"},
      {Kind::pass, "glass", "panes and blended surfaces; skipped while panes are kept with the G-buffer"},
      {Kind::pass, "filter", "the mean over the samples of a pixel, and with the frames before"},
  };
}

std::vector<Word> feature_words() {
  return {
      {Kind::feature, "visibility",
       "shadows of the environment, per vertex and direction, or by rays through the octree"},
      {Kind::feature, "shadow_rays",
       "shadows of suns and lamps at every point, by rays that the processor traces; at rest of the whole sky"},
      {Kind::feature, "lights", "punctual lights and surfaces that glow, sampled"},
      {Kind::feature, "texture_bandwidth", "the bandwidth of textures in the prediction"},
      {Kind::feature, "sampling", "random samples of the BRDF and the environment"},
      {Kind::feature, "multisampling", "several samples a pixel"},
      {Kind::feature, "parts", "parts of the scene have shading modes of their own (`--mode-of`)"},
      {Kind::feature, "normal_maps", "textures of normals"},
      {Kind::feature, "alpha_mask", "surfaces with parts cut out"},
      {Kind::feature, "measured_materials", "materials with tables of measured BRDFs"},
      {Kind::feature, "sheen", "materials without a table that have this lobe"},
      {Kind::feature, "clearcoat", "the same for this one"},
      {Kind::feature, "surface_details",
       "a second part of the G-buffer: occlusion, anisotropy, iridescence, the coat's normals and what textures say of "
       "coat, specular and sheen"},
      {Kind::feature, "subdivision", "meshes with a control cage"},
      {Kind::feature, "reflections", "mirrors and glass that show the scene"},
      {Kind::feature, words::kOctree,
       "cells that hold the scene's surfaces, for traced visibility and reflector techniques whose rays go through it"},
      {Kind::feature, "cell_brdfs", "BRDFs of the octree's cells (`octree.brdf`)"},
      {Kind::feature, "patch_fit",
       "bicubic patches fitted to curved meshes: how many, and the largest distance of a vertex from them; left out: "
       "meshes that they are still being fitted to"},
  };
}

std::vector<Word> resource_words() {
  return {
      {Kind::resource, "geometry", "vertices and indices"},
      {Kind::resource, "textures", "texels of the scene's images"},
      {Kind::resource, "materials", "BRDF tables with their importance, albedo and bandwidth"},
      {Kind::resource, "environment", "radiance, importance and bandwidth of the sky"},
      {Kind::resource, "shading", "radiance, the picture, lists of what to shade"},
      {Kind::resource, "accumulation",
       "what every point has gathered while nothing moves (mean, spread, deviation, what interpolation is worth), or "
       "while only the light rotates (mean, age)"},
  };
}

}  // namespace

std::vector<Word> vocabulary(const Registry& registry) {
  std::vector<Word> all = pass_words();
  for (const Technique& technique : registry.techniques)
    all.insert(all.end(), technique.words.begin(), technique.words.end());
  for (const std::vector<Word>& more : {feature_words(), resource_words()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace maquette

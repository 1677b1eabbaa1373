#include "render/prt/buffers.h"

#include <algorithm>
#include <bit>

#include "render/gl/bindings.h"
#include "render/prt/view_table.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr const char* kWhere = "radiance transfer";

/// Words of a record: its first row, then weights.
std::size_t record_words(int components) {
  const std::size_t words = 1 + static_cast<std::size_t>(components + 1) / 2;
  return (words + 3) / 4 * 4;
}

std::size_t records_of(const TransferGroup& group) {
  return group.fit.joint ? group.fit.joint->function_count() : group.matrices.size();
}

/// The first `own` of every `stored` half floats, four a texel.
void append_halves(const std::vector<std::uint16_t>& halves, std::size_t stored, std::size_t own,
                   std::vector<std::uint64_t>* texels) {
  for (std::size_t t = 0; t < halves.size() / stored; ++t)
    for (std::size_t k = 0; k < own; k += 4) {
      std::uint64_t four = 0;
      for (std::size_t c = k; c < std::min(k + 4, own); ++c)
        four |= static_cast<std::uint64_t>(halves[t * stored + c]) << (16 * (c % 4));
      texels->push_back(four);
    }
}

}  // namespace

TransferBuffers::Limits TransferBuffers::Limits::of_driver() {
  GLint texels = 0, block = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
  glGetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
  return {static_cast<std::size_t>(texels), static_cast<std::size_t>(block)};
}

template <typename T>
TransferBuffers::Table TransferBuffers::make_table(const char* label, GLenum format, const std::vector<T>& values,
                                                   const std::string& remedy) const {
  const std::vector<T> one(1);
  const std::vector<T>& stored = values.empty() ? one : values;
  const std::size_t texels = stored.size() * sizeof(T) / texel_bytes(format);
  if (texels > limits_.texels)
    throw Error(kWhere,
                std::string(label) + ": " + std::to_string(texels) + " values are more than this driver can address (" +
                    std::to_string(limits_.texels) + ")",
                remedy);
  Table table;
  table.buffer = Buffer::from(label, stored);
  table.view = Texture::make_buffer(label, format, table.buffer);
  return table;
}

TransferBuffers::TransferBuffers(const Transfer& transfer, std::size_t triangles, const Limits& limits)
    : limits_(limits) {
  vertex_count_ = static_cast<int>(transfer.mesh.vertices.size());
  components_ = transfer.bake->options.components;
  int components_of_materials = 0;
  for (const TransferGroup& group : transfer.bake->groups)
    components_of_materials = std::max(components_of_materials, group.fit.components);
  terms_ = transfer_terms(components_of_materials);
  for (const TransferGroup& group : transfer.bake->groups)
    if (group.fit.joint) functions_ = std::max(functions_, static_cast<int>(group.fit.joint->function_count()));
  if (joint()) rows_of_view_ = transfer.bake->options.joint_clusters * (1 + components_);
  upload_triangles(transfer, triangles);
  upload_vertices(transfer);
  upload_records(transfer);
  upload_materials(transfer);
  sums_ = make_table("transfer sums", GL_RGBA32F, std::vector<glm::vec4>(transfer.bake->table.rows(), glm::vec4(0.0f)),
                     "take fewer clusters (prt.clusters)");
  const auto of_vertex = static_cast<std::size_t>(joint() ? functions_ : 3 * terms_);
  const std::size_t shown = transfer.mesh.vertices.size() * of_vertex;
  // Storage buffers may begin at multiples of 256 bytes: 16 texels.
  constexpr std::size_t kStep = 16;
  const std::size_t at_once = limits_.storage_bytes / sizeof(glm::vec4) / of_vertex / kStep * kStep;
  if (at_once == 0) throw Error(kWhere, "this driver has no storage buffers that are large enough", "take another one");
  vertices_at_once_ = static_cast<int>(std::min<std::size_t>(at_once, 1u << 30));
  shown_ = make_table("transfer shown", GL_RGBA32F, std::vector<glm::vec4>(shown, glm::vec4(0.0f)),
                      "choose fewer vertices (prt.vertices)");
}

void TransferBuffers::upload_triangles(const Transfer& transfer, std::size_t triangles) {
  std::vector<glm::uvec4> places(triangles, glm::uvec4(0u));
  for (const TransferMesh::Triangle& t : transfer.mesh.triangles) {
    const TransferPart& part = transfer.mesh.parts[t.part];
    places[t.source] = {t.first + 1, static_cast<std::uint32_t>(t.level),
                        std::bit_cast<std::uint32_t>(part.tiles_per_uv_x),
                        std::bit_cast<std::uint32_t>(part.tiles_per_uv_y)};
  }
  triangles_ = make_table("transfer triangles", GL_RGBA32UI, places, "choose fewer parts (prt.parts)");
  grid_ = make_table("transfer grid", GL_R32UI, transfer.mesh.grid, "choose fewer vertices (prt.vertices)");
}

void TransferBuffers::upload_vertices(const Transfer& transfer) {
  std::vector<glm::vec4> vertices;
  for (const TransferVertex& v : transfer.mesh.vertices)
    for (const glm::vec3& x : {v.position, v.n, v.t, v.b}) vertices.emplace_back(x, 0.0f);
  for (const TransferGroup& group : transfer.bake->groups)
    for (std::size_t i = 0; i < group.vertices.size(); ++i) vertices[4 * group.vertices[i]].w = group.errors[i];
  vertices_ = make_table("transfer vertices", GL_RGBA32F, vertices, "choose fewer vertices (prt.vertices)");
}

void TransferBuffers::upload_records(const Transfer& transfer) {
  const int components = transfer.bake->options.components;
  const std::size_t words = record_words(components), texels = words / 4;
  std::size_t all = 0, vertices = 0;
  for (const TransferGroup& group : transfer.bake->groups) {
    all += group.vertices.size() * records_of(group) * texels;
    vertices += group.vertices.size();
  }
  if (all > limits_.texels)
    throw Error(
        kWhere,
        std::to_string(vertices) + " vertices of " + std::to_string(16 * all / std::max<std::size_t>(vertices, 1)) +
            " bytes are more than this driver can address; " + std::to_string(vertices * limits_.texels / all) + " fit",
        "choose fewer vertices (prt.vertices) or parts (prt.parts)");
  std::vector<std::uint32_t> records(4 * all, 0u);
  std::vector<glm::uvec2> places(transfer.mesh.vertices.size(), glm::uvec2(0u));
  std::size_t first = 0;
  const auto terms = static_cast<std::uint32_t>(1 + components);
  for (std::size_t g = 0; g < transfer.bake->groups.size(); ++g) {
    const TransferGroup& group = transfer.bake->groups[g];
    for (std::size_t i = 0; i < group.vertices.size(); ++i) {
      places[group.vertices[i]] = {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(g)};
      // In the joint form those of a function's first view.
      const std::size_t step = group.fit.joint ? group.matrices.size() / records_of(group) : 1;
      for (std::size_t m = 0; m < group.matrices.size(); m += step, first += texels) {
        const TransferMatrix& matrix = group.matrices[m];
        std::uint32_t* record = records.data() + 4 * first;
        record[0] = static_cast<std::uint32_t>(group.rows[m]) + matrix.owner[i] * terms;
        for (std::size_t c = 0; c < static_cast<std::size_t>(components); ++c)
          record[1 + c / 2] |= static_cast<std::uint32_t>(matrix.weights[i * static_cast<std::size_t>(components) + c])
                               << (16 * (c % 2));
      }
    }
  }
  records_ = make_table("transfer weights", GL_RGBA32UI, records, "choose fewer vertices (prt.vertices)");
  places_ = make_table("transfer places", GL_RG32UI, places, "choose fewer vertices (prt.vertices)");
}

void TransferBuffers::upload_materials(const Transfer& transfer) {
  std::vector<glm::uvec4> groups;
  std::vector<glm::vec4> views;
  std::vector<std::uint64_t> factors;
  for (const TransferGroup& group : transfer.bake->groups) {
    const Btf& btf = *group.material;
    const std::size_t first = views.size(), own = static_cast<std::size_t>(3 * (1 + group.fit.components)),
                      stored = static_cast<std::size_t>(3 * (1 + btf.components));
    const ViewTableSize size = append_view_table(btf.view_mesh, &views);
    groups.emplace_back(group.fit.joint ? records_of(group) : static_cast<std::size_t>(group.fit.components), first,
                        size.triangles, size.borders);
    groups.emplace_back(factors.size(), btf.width, btf.height, group.fit.components);
    if (group.fit.joint) {
      append_halves(group.fit.joint->texels, group.fit.joint->texel_halves(), group.fit.joint->texel_halves(),
                    &factors);
      continue;
    }
    for (const BtfView& view : btf.views) append_halves(view.factors, stored, own, &factors);
  }
  groups_ = make_table("transfer groups", GL_RGBA32UI, groups, "choose fewer parts (prt.parts)");
  views_ = make_table("transfer views", GL_RGBA32F, views, "choose fewer parts (prt.parts)");
  factors_ = make_table("transfer eigen-textures", GL_RGBA16F, factors,
                        "take fewer components (prt.btf_components) or a smaller BTF");
}

void TransferBuffers::set_sums(const std::vector<glm::vec4>& sums) {
  if (!sums.empty()) sums_.buffer.update(0, sums.size() * sizeof(glm::vec4), sums.data());
}

void TransferBuffers::bind_shown(int first) const {
  const std::size_t of_vertex = sizeof(glm::vec4) * static_cast<std::size_t>(joint() ? functions_ : 3 * terms_);
  const int count = std::min(vertices_at_once_, vertex_count_ - first);
  glBindBufferRange(GL_SHADER_STORAGE_BUFFER, kBufferTransferShown, shown_.buffer.get(),
                    static_cast<GLintptr>(static_cast<std::size_t>(first) * of_vertex),
                    static_cast<GLsizeiptr>(static_cast<std::size_t>(count) * of_vertex));
}

void TransferBuffers::bind() const {
  glBindTextureUnit(kUnitTransferTriangles, triangles_.view.get());
  glBindTextureUnit(kUnitTransferGrid, grid_.view.get());
  glBindTextureUnit(kUnitTransferVertices, vertices_.view.get());
  glBindTextureUnit(kUnitTransferPlaces, places_.view.get());
  glBindTextureUnit(kUnitTransferRecords, records_.view.get());
  glBindTextureUnit(kUnitTransferSums, sums_.view.get());
  glBindTextureUnit(kUnitTransferGroups, groups_.view.get());
  glBindTextureUnit(kUnitTransferViews, views_.view.get());
  glBindTextureUnit(kUnitTransferFactors, factors_.view.get());
  glBindTextureUnit(kUnitTransferShown, shown_.view.get());
}

std::size_t TransferBuffers::bytes() const {
  std::size_t sum = 0;
  for (const Table* table :
       {&triangles_, &grid_, &vertices_, &places_, &records_, &sums_, &groups_, &views_, &factors_, &shown_})
    sum += table->buffer.bytes();
  return sum;
}

}  // namespace maquette

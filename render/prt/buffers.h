#pragma once

#include <vector>

#include "render/gl/objects.h"
#include "render/prt/transfer_bake.h"

namespace maquette {

/// Components of materials at most that shaders sum.
inline constexpr int kMostMaterialComponents = 8;

/// Terms (the mean and components) that the shaders of a setting are compiled for.
constexpr int transfer_terms(int btf_components) { return btf_components <= 2 ? 3 : 1 + kMostMaterialComponents; }

/// Transfer on the GPU, as shaders/prt reads it.
class TransferBuffers {
 public:
  /// What one buffer may hold.
  struct Limits {
    std::size_t texels = 0, storage_bytes = 0;
    static Limits of_driver();
  };
  /// `triangles`: of the geometry. Throws Error where `limits` cannot hold it, saying how many vertices fit.
  TransferBuffers(const Transfer& transfer, std::size_t triangles, const Limits& limits = Limits::of_driver());
  /// `sums`: [row], of RelightTable.
  void set_sums(const std::vector<glm::vec4>& sums);
  void bind() const;
  /// Vertices that the vertex stage writes at a time: as many as one storage buffer can hold.
  int vertices_at_once() const { return vertices_at_once_; }
  void bind_shown(int first) const;  ///< from that vertex on
  std::size_t bytes() const;
  int vertices() const { return vertex_count_; }
  int components() const { return components_; }  ///< of the transfer
  int terms() const { return terms_; }            ///< transfer_terms
  bool joint() const { return functions_ > 0; }
  int functions() const { return functions_; }        ///< of the material with most, in the joint form; else 0
  int rows_of_view() const { return rows_of_view_; }  ///< of sums, in the joint form

 private:
  void upload_triangles(const Transfer& transfer, std::size_t triangles);
  void upload_vertices(const Transfer& transfer);
  void upload_records(const Transfer& transfer);
  void upload_materials(const Transfer& transfer);

  struct Table {
    Buffer buffer;
    Texture view;
  };
  template <typename T>
  Table make_table(const char* label, GLenum format, const std::vector<T>& values, const std::string& remedy) const;

  Limits limits_;
  int vertex_count_ = 0, components_ = 0, terms_ = 3, functions_ = 0, rows_of_view_ = 0, vertices_at_once_ = 0;
  Table triangles_, grid_, vertices_, places_, records_, sums_, groups_, views_, factors_;
  Table shown_;  ///< what the vertex stage writes
};

}  // namespace maquette

// `uniform` at high counts against direct quadrature of the same tables and texels.
#include "tests/benchmarks/stage.h"
#include "tests/support/sphere_quadrature.h"

namespace maquette::bench {

Figures measure_correct(Stage& stage) {
  Figures figures;
  for (const char* name : {"matte-white", "paint-red-metallic", "metal-chrome"}) {
    if (!stage.options().wants(std::string("correct/") + name)) continue;
    const std::string material = std::string("builtin:") + name;
    const Case c{.name = std::string("correct/") + name,
                 .scene = "builtin:sphere",
                 .material = material,
                 .width = 32,
                 .height = 32};
    stage.show(c);
    const FrameRequest r = stage.request("uniform", 4096);
    Image picture(c.width, c.height, 4);
    constexpr std::uint32_t kSeeds = 16;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      for (int f = 0; f < 16; ++f) stage.renderer().render(stage.request("uniform", 4096, seed), true);
      const Image part = stage.renderer().read_radiance();
      for (std::size_t i = 0; i < part.data.size(); ++i) picture.data[i] += part.data[i] / kSeeds;
    }
    const Environment environment = load_environment(c.environment);
    const test::SphereQuadrature exact =
        test::integrate_sphere(environment, load_brdf(material), {r.camera.eye.z, r.camera.fov_y_rad, 32}, nullptr);
    const Image normals = stage.renderer().read_debug_view("normal");
    const test::SphereQuadrature stored =
        test::integrate_sphere(environment, load_brdf(material), {r.camera.eye.z, r.camera.fov_y_rad, 32}, &normals);
    const double error = test::relative_rmse(picture, stored), of_sphere = test::relative_rmse(picture, exact);
    figures.push_back(judged(std::string("uniform against quadrature, ") + name, "<= 0.5 %",
                             number(100.0 * error) + " % over " + std::to_string(exact.pixels.size()) +
                                 " pixels at the normals of the G-buffer (" + number(100.0 * of_sphere) +
                                 " % at those of the ideal sphere)",
                             error <= 0.005));
  }
  figures.push_back(
      shown("peak of the sky over its mean", number(test::peak_over_mean(load_environment("builtin:clear-sky")))));
  return figures;
}

}  // namespace maquette::bench

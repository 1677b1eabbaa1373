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
    const FrameRequest r = stage.request("uniform", 4096, 3);
    for (int f = 0; f < 32; ++f) stage.renderer().render(r, true);
    const Image picture = stage.renderer().read_radiance();
    const Environment environment = load_environment(c.environment);
    const test::SphereQuadrature exact =
        test::integrate_sphere(environment, load_brdf(material), {r.camera.eye.z, r.camera.fov_y_rad, 32}, nullptr);
    const Image normals = stage.renderer().read_debug_view("normal");
    const test::SphereQuadrature stored =
        test::integrate_sphere(environment, load_brdf(material), {r.camera.eye.z, r.camera.fov_y_rad, 32}, &normals);
    const double error = test::relative_rmse(picture, exact), of_stored = test::relative_rmse(picture, stored);
    figures.push_back(judged(std::string("uniform against quadrature, ") + name, "<= 0.5 %",
                             number(100.0 * error) + " % over " + std::to_string(exact.pixels.size()) +
                                 " pixels (with the G-buffer's normals " + number(100.0 * of_stored) +
                                 " %; quadrature " + number(100.0 * exact.estimated_error) +
                                 " %; peak of the sky over its mean " + number(test::peak_over_mean(environment)) + ")",
                             error <= 0.005));
  }
  return figures;
}

}  // namespace maquette::bench

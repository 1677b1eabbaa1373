#include "viewer/report/references.h"

#include <chrono>
#include <cmath>
#include <filesystem>

#include "scenes/error.h"
#include "scenes/image_io.h"
#include "viewer/report/stop_signal.h"

namespace maquette::report {

namespace {

using Clock = std::chrono::steady_clock;

/// Mean of two independent halves; half their difference is the noise of the mean.
struct Halves {
  Image sums[2];
  int counts[2] = {0, 0};
  void add(int half, const Image& picture) {
    if (counts[half]++ == 0) sums[half] = Image(picture.width, picture.height, picture.channels);
    for (std::size_t i = 0; i < picture.data.size(); ++i) sums[half].data[i] += picture.data[i];
  }
  Image mean(int half) const {
    Image result = sums[half];
    for (float& value : result.data) value /= static_cast<float>(counts[half]);
    return result;
  }
  Image mean() const {
    Image result = mean(0);
    const Image other = mean(1);
    for (std::size_t i = 0; i < result.data.size(); ++i) result.data[i] = 0.5f * (result.data[i] + other.data[i]);
    return result;
  }
  double noise() const { return 0.5 * compare_images(mean(0), mean(1)).relative_rmse.value_or(0.0); }
};

Judge compute(Studio* studio, const ReferenceOrder& order, FrameRequest request) {
  constexpr int kSamples = 512;
  const Clock::time_point begin = Clock::now();
  request.mode = "uniform";
  request.samples = kSamples;
  if (order.scope == Scope::estimator) request.settings.set_from_text("shading.visibility", "none");
  Halves halves;
  Judge judge;
  double noise = 1.0, seconds = 0.0;
  for (int runs = 2; (seconds < order.seconds && noise > order.target_noise) || runs == 2; runs += 2) {
    for (int half = 0; half < 2; ++half) {
      request.seed = static_cast<std::uint32_t>(1000 + runs + half);
      studio->renderer().render(request);
      halves.add(half, studio->renderer().read_radiance());
    }
    if (StopSignal::asked()) break;
    noise = halves.noise();
    seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    judge.entry.samples = runs * kSamples;
  }
  judge.picture = halves.mean();
  judge.entry.noise = noise;
  judge.entry.seconds = seconds;
  judge.entry.made_by = "uniform";
  return judge;
}

}  // namespace

Judge obtain_reference(Studio* studio, Journal* journal, const std::string& folder, const ReferenceOrder& order) {
  const FrameRequest request = studio->request(order.camera);
  ContentKey key = studio->key();
  mix_request(request, &key);
  key.mix("reference").mix(scope_name(order.scope));
  if (const std::optional<ReferenceEntry> known = journal->find_reference(key.text())) {
    const std::string path = folder + "/" + known->file;
    if (std::filesystem::exists(path)) return {load_hdr_image(path), *known, key.text()};
  }
  Judge judge = compute(studio, order, request);
  judge.key = key.text();
  judge.entry.camera = order.camera.name;
  judge.entry.scope = order.scope;
  judge.entry.file = "references/" + judge.key + ".exr";
  if (StopSignal::asked()) return judge;  // half done: not to be taken for a reference later
  std::filesystem::create_directories(folder + "/references");
  save_exr(folder + "/" + judge.entry.file, judge.picture,
           {{"maquette.camera", order.camera.name}, {"maquette.scope", scope_name(order.scope)}});
  journal->add_reference(judge.key, judge.entry);
  return judge;
}

}  // namespace maquette::report

// docs/vocabulary.md, from the declarations of words and of the keys of `--stats`.
#include "viewer/vocabulary_page.h"

#include <utility>
#include <vector>

#include "render/frame/vocabulary.h"

namespace maquette {

namespace {

using Row = std::pair<std::string, std::string>;

std::string table(const std::string& head, const std::vector<Row>& rows) {
  std::string text = "| " + head + " | what |\n|---|---|\n";
  for (const auto& [name, meaning] : rows) text += "| " + name + " | " + meaning + " |\n";
  return text;
}

std::vector<Row> words_of(const std::vector<Word>& words, Word::Kind kind) {
  std::vector<Row> rows;
  for (const Word& word : words) {
    const Row row("`" + word.name + "`", word.meaning);
    bool known = false;
    for (const Row& other : rows) known = known || other.first == row.first;
    if (word.kind == kind && !known) rows.push_back(row);
  }
  return rows;
}

/// The keys of `--stats`.
std::vector<Row> stats_keys() {
  return {
      {"`scene`, `environment`, `mode`, `reflections`, `size`, `msaa`, `samples`, `seed`",
       "what was asked; `samples` 0: the mode's default"},
      {"`device`", "the driver's name and version"},
      {"`settings`", "every setting with its value"},
      {"`timing_ms.frame`", "median over `frames` measured frames; warm-up frames are not among them"},
      {"`timing_ms.passes`", "the same for each timed pass; `shade (sg)` where several modes share the frame"},
      {"`timing_ms.cpu_passes`",
       "processor time of all threads in each pass, on a software device: what a busy machine's clock cannot say"},
      {"`frames`", "how many frames were measured"},
      {"`accumulation.frames`, `.seconds`", "frames averaged in the picture, and how long it took"},
      {"`accumulation.estimated_relative_rmse`",
       "the error left, from the spread of the frames themselves; not what all have in common"},
      {"`memory.gpu_bytes`", "bytes by resource: the words of the tables below"},
      {"`memory.peak_rss_bytes`", "the most main memory the process had"},
      {"`bandwidth.visible_pixels`", "pixels where the scene is seen"},
      {"`bandwidth.shaded_pixels`", "pixels that were shaded; the others were interpolated"},
      {"`bandwidth.shading_samples`", "BRDF-times-light samples that were taken"},
      {"`technique`", "counters that only the technique at work has: the table below"},
      {"`modes`", "the shading mode of each node that has its own, `*`: of all others"},
      {"`plan`",
       "the frame plan: `pass` (in their order, preparations first) with `reason`, `reads`, `writes` and, where "
       "several "
       "modes share the frame, `mode`; then `feature` with `reason`"},
      {"`status`",
       "what the last frame could do: `bakes` that it wanted (`state`: absent, running, partial, ready or failed; "
       "`progress`), `frames_before` in its picture, `light_rotated` and `tables_swapped`: all that had changed"},
      {"`skipped`", "passes of the plan that the last frame did not need: `pass` and `why`"},
      {"`left_out`", "what the scene, the view or the settings leave out: `what` and `why`"},
      {"`error`",
       "with `--reference`, and of `maquette compare`: `rmse`, `relative_rmse`, `psnr` (dB, the reference's peak), "
       "`relmse`, `flip`, `flip_ldr`, `ssim`, `display_ev` (exposure of the last two), `pixels` (compared), `invalid` "
       "(left out: NaN or infinite), `notes` (why a figure is absent)"},
  };
}

}  // namespace

std::string vocabulary_markdown() {
  const std::vector<Word> words = vocabulary(builtin_registry());
  return "# Vocabulary\n\nThe words of the frame plan, of `--stats` and of `maquette inspect`. One word means one "
         "thing "
         "everywhere. Made by `maquette help --vocabulary` from the declarations in the program; a test keeps it "
         "current.\n\n## Passes\n\nIn the order of the plan a frame carries them out, or skips those whose result it "
         "has "
         "already; each is timed under its name in `timing_ms.passes`.\n\n" +
         table("pass", words_of(words, Word::Kind::pass)) +
         "\n## Features\n\nWhat a frame has besides, or, in `left_out`, does not have, with the reason.\n\n" +
         table("feature", words_of(words, Word::Kind::feature)) +
         "\n## `--stats`\n\nOne JSON object. Numbers that do not exist (a PSNR of equal pictures) are `null`.\n\n" +
         table("key", stats_keys()) + "\nKeys of `memory.gpu_bytes` are words of the tables above, and:\n\n" +
         table("resource", words_of(words, Word::Kind::resource)) + "\nKeys of `technique`:\n\n" +
         table("counter", words_of(words, Word::Kind::counter)) +
         "\n"
         "`maquette report` writes the same words: `report.json` holds `points` (`camera`, `technique`, "
         "`quality`, `scope`: `estimator` against unshadowed direct light, `model` against all light; "
         "`time_ms` and `relative_rmse` with `median`, `low`, `high` over the repeats; `error` as above, of "
         "the first repeat), `references` (`samples`: paths a pixel, `noise`: its own relative RMSE), `curves` "
         "(`pareto_front`, `time_ms_to_error` for each camera and their geometric mean), `left_out`, "
         "`not_measured`, `machine`. `report.csv` has one line a point.\n\n"
         "`relative_rmse` is the root of the mean square difference over R, G and B divided by the mean "
         "luminance of the reference, over the pixels where the reference's alpha is 1; the other figures are "
         "over the same pixels. `flip` is the mean of HDR-FLIP (Andersson et al. 2021), `flip_ldr` of LDR-FLIP "
         "(2020), both for 67 pixels a degree; `flip_ldr` and `ssim` (Wang et al. 2004, luma) look at both "
         "pictures tone mapped (pbr-neutral) at the exposure that shows the reference's log-average as 0.18.\n";
}

}  // namespace maquette

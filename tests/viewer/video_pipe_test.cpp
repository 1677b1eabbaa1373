// Videos hold the colours that they are given, and say how.
#include "viewer/video_pipe.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <glm/glm.hpp>

#include "scenes/error.h"
#include "scenes/image_io.h"
#include "tests/support/text.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

TEST(VideoPipe, BlackIsBlackAndWhiteIsWhiteInBt709) {
  if (std::system("ffprobe -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  const TemporaryFolder folder;
  const std::string video = folder.file("a:b.mp4"), frame = folder.file("frame.png"), raw = folder.file("raw");
  const std::pair<glm::vec3, std::string> colors[] = {{glm::vec3(0.0f), "black"},
                                                      {glm::vec3(1.0f), "white"},
                                                      {{1.0f, 0.0f, 0.0f}, "red"},
                                                      {{0.0f, 1.0f, 0.0f}, "green"}};
  {
    VideoPipe pipe(video, 2.0);
    for (const auto& [color, name] : colors) {
      Image image(64, 36, 3);
      for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = color[static_cast<int>(i % 3)];
      save_png(frame, image);
      pipe.add(frame);
    }
    pipe.finish();
  }
  const std::string named = "'file:" + video + "'";
  const std::string said = folder.file("said");
  ASSERT_EQ(std::system(("ffprobe -v error -show_entries "
                         "stream=color_space,color_transfer,color_primaries,color_range -of compact " +
                         named + " > '" + said + "'")
                            .c_str()),
            0);
  for (const char* tag : {"color_range=tv", "color_space=bt709", "color_transfer=bt709", "color_primaries=bt709"})
    EXPECT_TRUE(test::contains(read_text(said), tag)) << read_text(said);
  // As a player does that believes the tags.
  ASSERT_EQ(
      std::system(("ffmpeg -nostdin -loglevel error -y -i " + named +
                   " -vf scale=in_color_matrix=bt709:in_range=tv:out_range=pc -f rawvideo -pix_fmt rgb24 '" + raw + "'")
                      .c_str()),
      0);
  const std::string bytes = read_text(raw);
  constexpr std::size_t kFrame = 64u * 36u * 3u;
  ASSERT_EQ(bytes.size(), std::size(colors) * kFrame);
  for (std::size_t k = 0; k < std::size(colors); ++k)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(static_cast<unsigned char>(bytes[k * kFrame + kFrame / 2 + static_cast<std::size_t>(c)]),
                  255.0f * colors[k].first[c], k < 2 ? 0.0f : 3.0f)
          << colors[k].second;
}

/// ffmpeg ends with success where what it writes is cut off. A limit on the size of files stands for a disk that is
/// full.
TEST(VideoPipe, AVideoThatIsCutOffTakesNoNamesPlace) {
  if (std::system("ffprobe -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  const TemporaryFolder folder;
  const std::string video = folder.file("a.mp4"), frame = folder.file("frame.png");
  std::ofstream(video) << "an older video";
  Image image(64, 36, 3);
  save_png(frame, image);
  rlimit usual{};
  getrlimit(RLIMIT_FSIZE, &usual);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  {
    const rlimit small{1024, usual.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    VideoPipe pipe(video, 2.0);
    EXPECT_THROW(
        {
          for (int i = 0; i < 20; ++i) pipe.add(frame);
          pipe.finish();
        },
        Error);
  }
  setrlimit(RLIMIT_FSIZE, &usual);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(read_text(video), "an older video");
}

}  // namespace
}  // namespace maquette

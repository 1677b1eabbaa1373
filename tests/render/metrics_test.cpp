#include "render/metrics/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/views/false_color.h"
#include "scenes/error.h"

namespace maquette {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(Metrics, FollowTheirDefinitions) {
  Image reference(2, 1, 3, 2.0f), image(2, 1, 3, 2.0f);
  image.at(0, 0, 0) = 2.6f;  // one of six values off by 0.6
  const ErrorFigures f = compare_images(image, reference);
  const double rmse = std::sqrt(0.36 / 6.0);
  EXPECT_NEAR(*f.rmse, rmse, 1e-6);
  EXPECT_NEAR(*f.relative_rmse, rmse / 2.0, 1e-6);
  EXPECT_NEAR(*f.psnr, 20.0 * std::log10(2.0 / rmse), 1e-5);
  EXPECT_NEAR(*f.relmse, 0.36 / (4.0 + 0.04) / 6.0, 1e-6);
  EXPECT_FALSE(f.flip);  // only measure_error uses neighbouring pixels
  EXPECT_EQ(f.pixel_count, 2u);
}

TEST(Metrics, TheMeanIsTheReferencesLuminance) {
  Image reference(1, 1, 3), image(1, 1, 3);
  reference.at(0, 0, 1) = 1.0f;
  image.at(0, 0, 1) = 1.3f;
  EXPECT_NEAR(*compare_images(image, reference).relative_rmse, 0.3 / std::sqrt(3.0) / 0.7152, 1e-6);
}

TEST(Metrics, OnlyPixelsOfFullAlphaCount) {
  Image reference(3, 1, 4, 1.0f), image(3, 1, 3, 1.0f);
  reference.at(1, 0, 3) = 0.0f;
  reference.at(2, 0, 3) = 0.5f;
  image.at(1, 0, 0) = 100.0f;
  image.at(2, 0, 0) = 100.0f;
  const ErrorFigures f = compare_images(image, reference);
  EXPECT_EQ(*f.rmse, 0.0);
  EXPECT_EQ(f.pixel_count, 1u);
  EXPECT_FALSE(f.psnr);
}

TEST(Metrics, BrokenPixelsAreLeftOutAndCounted) {
  Image reference(3, 1, 3, 1.0f), image(3, 1, 3, 1.0f);
  image.at(0, 0, 1) = kNan;
  reference.at(1, 0, 2) = std::numeric_limits<float>::infinity();
  const ErrorFigures f = compare_images(image, reference);
  EXPECT_EQ(f.invalid_count, 2u);
  EXPECT_EQ(f.pixel_count, 1u);
  EXPECT_EQ(*f.rmse, 0.0);
}

TEST(Metrics, BlackReferencesHaveNoRelativeError) {
  const ErrorFigures f = compare_images(Image(4, 4, 3, 0.1f), Image(4, 4, 3));
  EXPECT_NEAR(*f.rmse, 0.1, 1e-7);
  EXPECT_FALSE(f.relative_rmse);
  EXPECT_FALSE(f.relmse);
  EXPECT_FALSE(f.psnr);
  EXPECT_FALSE(compare_images(Image(2, 2, 3, kNan), Image(2, 2, 3)).rmse);
}

TEST(Metrics, SizesMustAgree) {
  try {
    compare_images(Image(4, 3, 3), Image(4, 4, 3));
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("4 x 3"), std::string::npos);
  }
  EXPECT_THROW(compare_images(Image(4, 4, 1), Image(4, 4, 3)), Error);
}

TEST(MeasureError, EqualPicturesAndTheirNote) {
  Image image(24, 16, 4, 1.0f);
  for (int x = 0; x < 24; ++x)
    for (int y = 0; y < 16; ++y) image.at(x, y, 1) = 0.1f * static_cast<float>(x * y);
  const ErrorReport report = measure_error(image, image);
  EXPECT_EQ(*report.figures.flip, 0.0);
  EXPECT_EQ(*report.figures.flip_ldr, 0.0);
  EXPECT_NEAR(*report.figures.ssim, 1.0, 1e-5);
  EXPECT_EQ(report.figures.notes.size(), 1u);
  EXPECT_NE(report.figures.notes.front().find("equal"), std::string::npos);
}

TEST(MeasureError, BrokenPixelsDoNotSpread) {
  Image reference(40, 40, 3, 1.0f), image = reference;
  image.at(20, 20, 0) = kNan;
  const ErrorReport report = measure_error(image, reference);
  EXPECT_EQ(*report.figures.flip, 0.0);
  EXPECT_EQ(*report.figures.flip_ldr, 0.0);
  EXPECT_EQ(report.figures.invalid_count, 1u);
  EXPECT_NE(report.figures.notes.back().find("equal where both are finite"), std::string::npos);
  EXPECT_NE(report.figures.notes.front().find("NaN"), std::string::npos);
  const Image picture = difference_picture(report, image, reference);
  EXPECT_EQ(picture.at(20, 20, 0), 1.0f);
  EXPECT_EQ(picture.at(20, 20, 1), 0.0f);
  EXPECT_NE(picture.at(21, 20, 0), 1.0f);
}

TEST(MeasureError, BlackBrokenAndEmptyHaveAResult) {
  const ErrorReport black = measure_error(Image(8, 8, 3, 0.1f), Image(8, 8, 3));
  EXPECT_FALSE(black.figures.relative_rmse);
  EXPECT_GT(*black.figures.flip, 0.0);
  EXPECT_NE(black.figures.notes.front().find("black"), std::string::npos);
  EXPECT_EQ(*measure_error(Image(8, 8, 3), Image(8, 8, 3)).figures.flip, 0.0);
  const ErrorReport broken = measure_error(Image(8, 8, 3, kNan), Image(8, 8, 3));
  EXPECT_FALSE(broken.figures.flip);
  EXPECT_EQ(broken.figures.notes.size(), 2u);
  const ErrorReport sky = measure_error(Image(8, 8, 4), Image(8, 8, 4));
  EXPECT_FALSE(sky.figures.flip);
  EXPECT_NE(sky.figures.notes.front().find("sky"), std::string::npos);
  Image mostly(8, 8, 3);
  mostly.at(3, 3, 1) = 5.0f;
  const ErrorReport half = measure_error(Image(8, 8, 3, 0.1f), mostly);
  EXPECT_TRUE(std::isfinite(*half.figures.flip));
  EXPECT_NE(half.figures.notes.front().find("more than half"), std::string::npos);
}

TEST(MeasureError, TheSkyDoesNotCount) {
  Image reference(32, 32, 4, 1.0f), image = reference;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 32; ++x) {
      reference.at(x, y, 3) = 0.0f;
      image.at(x, y, 0) = 50.0f;
    }
  const ErrorFigures f = measure_error(image, reference).figures;
  EXPECT_EQ(*f.rmse, 0.0);
  EXPECT_LT(*f.flip, 0.35);  // only what the filter of the eye spreads over the edge
  EXPECT_EQ(f.pixel_count, 32u * 24u);
}

TEST(MeasureError, DisplayExposureShowsTheLogAverageAsGrey) {
  Image image(2, 1, 3);
  for (int c = 0; c < 3; ++c) {
    image.at(0, 0, c) = 0.5f;
    image.at(1, 0, c) = 8.0f;
  }
  EXPECT_NEAR(display_exposure_ev(image), std::log2(0.18 / 2.0), 1e-6);
  EXPECT_EQ(display_exposure_ev(Image(2, 2, 3)), 0.0);
}

TEST(FalseColor, RunsFromBlueToRedAndFlagsBrokenValues) {
  Image values(5, 1, 1);
  values.data = {0.0f, 5.0f, 10.0f, kNan, 1e9f};
  const Image colors = false_color_image(values, FalseColorRange{0.0f, 10.0f});
  ASSERT_EQ(colors.channels, 4);
  EXPECT_GT(colors.at(1, 0, 1), 0.8f);                       // green in the middle
  EXPECT_GT(colors.at(2, 0, 0), colors.at(2, 0, 2) + 0.3f);  // red at the top
  EXPECT_EQ(colors.at(3, 0, 0), 1.0f);
  EXPECT_EQ(colors.at(3, 0, 1), 0.0f);
  EXPECT_EQ(colors.at(3, 0, 2), 1.0f);
  for (int c = 0; c < 4; ++c) EXPECT_EQ(colors.at(4, 0, c), colors.at(2, 0, c));  // out of range is clamped
  // The legend's top is the high end.
  EXPECT_NEAR(false_color_legend(1, 1000).at(0, 0, 0), colors.at(2, 0, 0), 0.01f);
}

TEST(FalseColor, RangeIgnoresAHotPixelAndNothingAtAll) {
  Image values(1000, 1, 1, 2.0f);
  values.at(0, 0) = 1e9f;
  values.at(1, 0) = kNan;
  EXPECT_EQ(false_color_range(values).high, 2.0f);
  EXPECT_EQ(false_color_range(values).low, 0.0f);
  EXPECT_EQ(false_color_range(Image(4, 4, 1, kNan)).high, 1.0f);
  EXPECT_EQ(false_color_range(Image(4, 4, 1)).high, 1.0f);
  EXPECT_EQ(false_color_range(Image(0, 0, 1)).high, 1.0f);
}

}  // namespace
}  // namespace maquette

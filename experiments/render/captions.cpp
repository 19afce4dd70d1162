#include "experiments/render/captions.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/render/render.h"

namespace voxcarve {

namespace {

constexpr int kDpi = 72;                 ///< makes a point of the font a pixel
constexpr double kFontShare = 1.0 / 26;  ///< of the panel's shorter side
constexpr int kLargestFont = 64;         ///< pixels
constexpr int kSmallPanelFont = 11;      ///< pixels; where the share gives less
constexpr int kSmallestFont = 7;         ///< pixels; smaller ones cannot be read
constexpr double kWidthShare = 0.94;     ///< of the panel, for text
constexpr double kGreatestHeightShare = 1.0 / 3;
constexpr double kPadding = 0.5;  ///< above and below the text, in font sizes

/// The length of the well-formed UTF-8 sequence at `at`, or 0.
std::size_t sequence_length(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned lead = byte(at);
  if (lead < 0x80) return lead >= 0x20 && lead != 0x7f ? 1 : 0;
  const std::size_t length = lead >= 0xc2 && lead < 0xe0   ? 2
                             : lead >= 0xe0 && lead < 0xf0 ? 3
                             : lead >= 0xf0 && lead < 0xf5 ? 4
                                                           : 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xc0U) != 0x80) return 0;
  }
  // Overlong forms, surrogates and what lies above U+10FFFF.
  const unsigned second = byte(at + 1);
  const bool bad = (lead == 0xe0 && second < 0xa0) || (lead == 0xed && second >= 0xa0) ||
                   (lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second >= 0x90);
  return bad ? 0 : length;
}

/// Replaces what is not printable UTF-8, such as a file name in another encoding; tabs become spaces.
std::string printable(const std::string& text) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = sequence_length(text, at);
    if (length > 0) {
      result.append(text, at, length);
    } else {
      result += text[at] == '\t' ? ' ' : '?';
    }
    at += std::max<std::size_t>(length, 1);
  }
  return result;
}

/// Text of one font size.
class Typesetter {
 public:
  explicit Typesetter(int font) : renderer_(vtkTextRenderer::GetInstance()) {
    if (renderer_ == nullptr) throw ResourceError("cannot render: VTK has no text renderer");
    property_->SetFontFamilyToArial();
    property_->SetFontSize(font);
    property_->SetColor(1, 1, 1);
    property_->SetJustificationToCentered();
    property_->SetVerticalJustificationToBottom();
    property_->SetLineSpacing(1.15);
  }

  int width(const std::string& line) const {
    std::array<int, 4> box = {0, -1, 0, -1};
    if (line.empty() || !renderer_->GetBoundingBox(property_, line, box.data(), kDpi, vtkTextRenderer::FreeType))
      return 0;
    return box[1] - box[0] + 1;
  }

  /// Breaks lines at spaces where they exceed `limit` pixels. A longer word stays whole.
  std::string wrap(const std::string& text, int limit) const {
    std::vector<std::string> lines;
    for (const std::string& paragraph : split(text, '\n')) {
      std::string line;
      for (const std::string& word : split(printable(paragraph), ' ')) {
        const std::string longer = line.empty() ? word : line + ' ' + word;
        if (!line.empty() && width(longer) > limit) {
          lines.push_back(line);
          line = word;
        } else {
          line = longer;
        }
      }
      lines.push_back(line);
    }
    return join(lines, "\n");
  }

  TextMask draw(const std::string& text) const {
    TextMask mask;
    if (text.find_first_not_of(" \n") == std::string::npos) return mask;
    const vtkNew<vtkImageData> image;
    std::array<int, 2> size = {0, 0};
    if (!renderer_->RenderString(property_, text, image, size.data(), kDpi, vtkTextRenderer::FreeType)) {
      throw ResourceError("cannot render: the caption '" + text + "' cannot be drawn");
    }
    std::array<int, 6> extent{};
    image->GetExtent(extent.data());
    const int channels = image->GetNumberOfScalarComponents();
    mask.width = std::min(size[0], extent[1] - extent[0] + 1);
    mask.height = std::min(size[1], extent[3] - extent[2] + 1);
    mask.ink.reserve(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height));
    for (int y = mask.height - 1; y >= 0; --y) {
      const auto* row = static_cast<const unsigned char*>(image->GetScalarPointer(extent[0], extent[2] + y, 0));
      for (int x = 0; x < mask.width; ++x) mask.ink.push_back(row[x * channels + channels - 1]);
    }
    return mask;
  }

 private:
  vtkTextRenderer* renderer_;
  vtkNew<vtkTextProperty> property_;
};

/// Keeps the top left part.
void crop(TextMask& mask, int width, int height) {
  if (mask.width <= width && mask.height <= height) return;
  TextMask cropped{std::min(mask.width, width), std::min(mask.height, height), {}};
  for (int y = 0; y < cropped.height; ++y) {
    const auto row = mask.ink.begin() + static_cast<std::ptrdiff_t>(y) * mask.width;
    cropped.ink.insert(cropped.ink.end(), row, row + cropped.width);
  }
  mask = std::move(cropped);
}

}  // namespace

bool captions_available() {
  return true;
}

CaptionBand set_captions(const std::vector<std::string>& captions, int panel_width, int panel_height) {
  const int width_limit = std::max(1, static_cast<int>(panel_width * kWidthShare));
  const int height_limit = static_cast<int>(panel_height * kGreatestHeightShare);
  int font =
      std::clamp(static_cast<int>(std::min(panel_width, panel_height) * kFontShare), kSmallPanelFont, kLargestFont);
  CaptionBand band;
  for (;; --font) {
    const Typesetter typesetter(font);
    int widest = 0;
    int tallest = 0;
    band.masks.clear();
    for (const std::string& caption : captions) {
      band.masks.push_back(typesetter.draw(typesetter.wrap(caption, width_limit)));
      widest = std::max(widest, band.masks.back().width);
      tallest = std::max(tallest, band.masks.back().height);
    }
    if (tallest == 0) return band;
    band.padding = static_cast<int>(std::ceil(kPadding * font));
    band.height = tallest + 2 * band.padding;
    if (font == kSmallestFont || (widest <= width_limit && band.height <= height_limit)) break;
  }
  band.height = std::min(band.height, height_limit);
  band.padding = std::min(band.padding, band.height);
  for (TextMask& mask : band.masks) crop(mask, width_limit, band.height - band.padding);
  return band;
}

}  // namespace voxcarve

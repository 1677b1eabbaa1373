#include "tests/ui/x11.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <thread>

namespace maquette::test {

namespace {

constexpr double kLimit_s = 600.0;  // only a hang takes so long

struct Close {
  void operator()(Display* display) const { XCloseDisplay(display); }
};
using OpenDisplay = std::unique_ptr<Display, Close>;

OpenDisplay open_display(const std::string& name) {
  OpenDisplay display(XOpenDisplay(name.c_str()));
  if (!display) throw std::runtime_error("no display " + name);
  return display;
}

/// The window that has a name and is shown; 0: none.
Window program_window(Display* display) {
  Window root = 0, parent = 0, *children = nullptr, found = 0;
  unsigned count = 0;
  if (!XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count)) return 0;
  for (unsigned i = 0; i < count; ++i) {
    XWindowAttributes attributes;
    char* name = nullptr;
    if (XFetchName(display, children[i], &name) && XGetWindowAttributes(display, children[i], &attributes) &&
        attributes.map_state == IsViewable)
      found = children[i];
    if (name) XFree(name);
  }
  if (children) XFree(children);
  return found;
}

std::string uri_of(const std::string& file) {
  std::string uri = "file://";
  for (const char c : std::filesystem::absolute(file).string())
    uri += c == ' ' ? std::string("%20") : std::string(1, c);
  return uri + "\r\n";
}

/// The side of a drag and drop that has the files. Source: freedesktop.org, "Drag-and-Drop Protocol for the X Window
/// System", version 5.
class DragSource {
 public:
  DragSource(Display* display, Window target, const std::vector<std::string>& files)
      : display_(display), target_(target) {
    for (const std::string& file : files) uris_ += uri_of(file);
    own_ = XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0);
    XSetSelectionOwner(display, atom("XdndSelection"), own_, CurrentTime);
  }
  ~DragSource() { XDestroyWindow(display_, own_); }
  DragSource(const DragSource&) = delete;
  DragSource& operator=(const DragSource&) = delete;

  bool drop(int x, int y) {
    constexpr long kVersion = 5;
    send("XdndEnter", kVersion << 24, static_cast<long>(atom("text/uri-list")), 0, 0);
    send("XdndPosition", 0, static_cast<long>(x) << 16 | y, 0, static_cast<long>(atom("XdndActionCopy")));
    bool dropped = false;
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kLimit_s);
    while (std::chrono::steady_clock::now() < end) {
      if (XPending(display_) == 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        continue;
      }
      XEvent event;
      XNextEvent(display_, &event);
      if (event.type == SelectionRequest) give(event.xselectionrequest);
      if (event.type != ClientMessage) continue;
      if (event.xclient.message_type == atom("XdndFinished")) return true;
      if (event.xclient.message_type != atom("XdndStatus") || dropped) continue;
      dropped = true;
      send("XdndDrop", 0, CurrentTime, 0, 0);
    }
    return false;
  }

 private:
  Atom atom(const char* name) const { return XInternAtom(display_, name, False); }

  void send(const char* type, long a, long b, long c, long d) const {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = target_;
    event.xclient.message_type = atom(type);
    event.xclient.format = 32;
    const long data[] = {static_cast<long>(own_), a, b, c, d};
    std::copy(std::begin(data), std::end(data), event.xclient.data.l);
    XSendEvent(display_, target_, False, NoEventMask, &event);
    XFlush(display_);
  }

  void give(const XSelectionRequestEvent& asked) const {
    XChangeProperty(display_, asked.requestor, asked.property, asked.target, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(uris_.data()), static_cast<int>(uris_.size()));
    XEvent answer{};
    answer.xselection.type = SelectionNotify;
    answer.xselection.requestor = asked.requestor;
    answer.xselection.selection = asked.selection;
    answer.xselection.target = asked.target;
    answer.xselection.property = asked.property;
    answer.xselection.time = asked.time;
    XSendEvent(display_, asked.requestor, False, NoEventMask, &answer);
    XFlush(display_);
  }

  Display* display_;
  Window target_, own_ = 0;
  std::string uris_;
};

}  // namespace

ScreenPicture grab_screen(const std::string& name) {
  const OpenDisplay display = open_display(name);
  XWindowAttributes screen;
  XGetWindowAttributes(display.get(), DefaultRootWindow(display.get()), &screen);
  XImage* image = XGetImage(display.get(), DefaultRootWindow(display.get()), 0, 0, static_cast<unsigned>(screen.width),
                            static_cast<unsigned>(screen.height), AllPlanes, ZPixmap);
  if (!image) throw std::runtime_error("no picture of display " + name);
  ScreenPicture picture{screen.width, screen.height, {}};
  picture.rgb.reserve(3 * static_cast<std::size_t>(screen.width) * static_cast<std::size_t>(screen.height));
  for (int y = 0; y < screen.height; ++y)
    for (int x = 0; x < screen.width; ++x) {
      const unsigned long pixel = XGetPixel(image, x, y);
      for (const int shift : {16, 8, 0}) picture.rgb.push_back(static_cast<std::uint8_t>(pixel >> shift & 255u));
    }
  XDestroyImage(image);
  return picture;
}

bool drop_files(const std::string& name, int x, int y, const std::vector<std::string>& files) {
  const OpenDisplay display = open_display(name);
  const Window target = program_window(display.get());
  return target != 0 && DragSource(display.get(), target, files).drop(x, y);
}

void set_dpi(const std::string& name, int dpi) {
  const OpenDisplay display = open_display(name);
  const std::string text = "Xft.dpi:\t" + std::to_string(dpi) + "\n";
  XChangeProperty(display.get(), DefaultRootWindow(display.get()), XA_RESOURCE_MANAGER, XA_STRING, 8, PropModeReplace,
                  reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  XSync(display.get(), False);
}

WindowSize window_size(const std::string& name) {
  const OpenDisplay display = open_display(name);
  const Window window = program_window(display.get());
  XWindowAttributes attributes;
  if (window == 0 || !XGetWindowAttributes(display.get(), window, &attributes)) return {};
  return {attributes.width, attributes.height};
}

}  // namespace maquette::test

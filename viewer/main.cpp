#include "render/raytraced/large_pages.h"
#include "viewer/commands.h"

int main(int argc, char** argv) {
  maquette::restart_in_large_pages(argv);
  return maquette::run_program(argc, argv);
}

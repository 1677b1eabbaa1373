#include "viewer/commands.h"

int main(int argc, char** argv) { return maquette::run_program(argc, argv); }

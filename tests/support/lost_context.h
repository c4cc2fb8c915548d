#pragma once
// A graphics driver that loses contexts. Link lost_context.cpp: its eglGetProcAddress and drawing calls stand before
// those of the system, and pass everything on until a loss.

namespace rotunda::tests {

// The next `times` contexts that ask for their state are lost when they ask for the `shown`th time: nothing is drawn in
// them any more. Forgets those before.
void lose_contexts(int times, int shown);
int contexts_lost();

}  // namespace rotunda::tests

"""Events of missions: a closed set, their codec, and the state that follows from them. Pure."""

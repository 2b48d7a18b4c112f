namespace grouser::vehicle {}

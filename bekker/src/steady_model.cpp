namespace grouser::bekker {}

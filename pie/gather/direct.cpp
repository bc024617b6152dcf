// direct

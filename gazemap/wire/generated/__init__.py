"""Made by `make proto` from gazemap/wire/proto; never edited."""

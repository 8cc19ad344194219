"""Soccer on a real RoboCup Soccer Simulator: rcssserver's protocol, and a world using it."""

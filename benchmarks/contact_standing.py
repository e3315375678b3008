def write_standing(board, path):
    pass
